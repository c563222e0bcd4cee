"""The median of many places at once against numpy's."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.core import known_median


@pytest.mark.parametrize("count", [1, 2, 3, 7, 14, 33, 64])
def test_it_is_the_median_of_what_is_known(count: int) -> None:
    """To the last bit of single precision; of more places than are sorted side by side."""
    rng = np.random.default_rng(count)
    stack = rng.uniform(0.0, 255.0, (count, 11, 13)).astype(np.float32)
    stack[rng.uniform(size=stack.shape) < 0.3] = np.nan
    enough = np.isfinite(stack).sum(0) >= 2
    found = known_median(stack, least=2)
    np.testing.assert_array_equal(np.isfinite(found), enough)
    np.testing.assert_array_equal(found[enough], np.nanmedian(stack[:, enough], axis=0))


def test_bytes_have_a_median_between_them() -> None:
    stack = np.array([[3, 250], [4, 10], [9, 20], [200, 255]], np.uint8)
    np.testing.assert_array_equal(known_median(stack), [6.5, 135.0])
