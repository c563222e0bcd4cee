"""How well a turned picture explains a frame, at all angles at once."""

from __future__ import annotations

import numpy as np

from servosight.tracking.verification import PolarView
from servosight.tracking.verification._turning import Gains


def test_rows_in_which_a_part_does_not_lie_make_no_difference() -> None:
    """The gains of a part in 8 of 40 rows, from spectra of all rows and of these alone; some of the
    pictures' cells are not known."""
    view, rng = PolarView.around((50.0, 50.0), 40.0), np.random.default_rng(1)
    seen = rng.uniform(0.0, 255.0, (3, view.rows, view.columns)).astype(np.float32)
    seen[:, 20:30, 5:9] = np.nan
    behind, part = seen[0][::-1].copy(), np.roll(seen[1], 7, axis=1)
    cover = np.zeros((view.rows, view.columns), np.float32)
    cover[12:20, 30:90] = 1.0
    whole = Gains.of(view, seen, behind).by(part, cover)
    some = Gains.of(view, seen, behind, slice(12, 20)).by(part, cover)
    assert np.ptp(whole) > 1e6
    np.testing.assert_allclose(some, whole, rtol=1e-5, atol=1e-5 * np.abs(whole).max())
