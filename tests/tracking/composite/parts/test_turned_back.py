"""Pictures turned back on a raster, and what a part leaves of them, beside numpy's own."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from servosight.tracking.composite.parts._turned_back import misfits, turned_back, without_part

ROWS, COLUMNS = 3, 8


def rolled(stack: np.ndarray, turns: list[int]) -> np.ndarray:
    return np.stack([np.roll(one, turn, axis=1) for one, turn in zip(stack, turns, strict=True)])


@given(
    turns=st.lists(st.integers(-2 * COLUMNS, 2 * COLUMNS), min_size=1, max_size=4),
    seed=st.integers(0, 99),
)
def test_they_do_what_rolling_each_picture_does(turns: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    seen = rng.uniform(0.0, 255.0, (len(turns), ROWS, COLUMNS)).astype(np.float32)
    part, behind = rng.uniform(0.0, 255.0, (2, ROWS, COLUMNS)).astype(np.float32)
    for values in (seen, part, behind):
        values[rng.uniform(size=values.shape) < 0.2] = np.nan
    cover = rng.uniform(size=(ROWS, COLUMNS)) < 0.5
    back = rolled(seen, [-turn for turn in turns])
    np.testing.assert_array_equal(turned_back(seen, np.array(turns)), back)
    on = rolled(np.broadcast_to(cover, seen.shape), turns)
    left = without_part(seen, cover, np.array(turns))
    np.testing.assert_array_equal(left, np.where(on, np.nan, seen))
    still = rolled(np.broadcast_to(behind, seen.shape), [-turn for turn in turns])
    own, against, share = misfits(seen, np.array(turns), part, behind)
    np.testing.assert_allclose(share, np.isfinite(back).mean(0), rtol=1e-6)
    for found, squares in ((own, (back - part) ** 2), (against, (back - still) ** 2)):
        known = np.isfinite(squares).sum(0)
        mean = np.nansum(squares, 0)[known > 0] / known[known > 0]
        np.testing.assert_allclose(found[known > 0], mean, rtol=1e-5)
        assert np.isnan(found[known == 0]).all()
