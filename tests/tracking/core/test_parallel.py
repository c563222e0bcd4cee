"""Work in threads comes back in order, whatever their number."""

from __future__ import annotations

import numba
import pytest

from servosight.tracking.core import chunks, threaded


@pytest.mark.parametrize("threads", [1, 3])
def test_results_come_in_order(threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", threads)
    assert threaded(lambda number: number * number, range(20)) == [n * n for n in range(20)]
    assert threaded(str, []) == []


@pytest.mark.parametrize("count", [0, 1, 3, 4, 25])
def test_chunks_hold_each_number_once(count: int) -> None:
    assert [n for chunk in chunks(count) for n in chunk] == list(range(count))
    assert len(chunks(count)) <= 4


def test_an_error_is_raised() -> None:
    with pytest.raises(ZeroDivisionError):
        threaded(lambda number: 1 // number, [1, 0])


def test_a_function_may_itself_work_in_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", 2)

    def sums(number: int) -> int:
        return sum(threaded(lambda other: number + other, range(8)))

    assert threaded(sums, range(8)) == [8 * number + 28 for number in range(8)]
