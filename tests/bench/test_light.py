"""The coded light is a maximal-length sequence, and any second of it is unique."""

from __future__ import annotations

import numpy as np
from support.filmed_wire import seen_share

from servosight.bench.light import BIT_S, ORDER, PERIOD_BITS, lit, pattern


def test_any_ten_bits_occur_once() -> None:
    bits = np.concatenate((pattern(), pattern()[: ORDER - 1]))
    words = np.lib.stride_tricks.sliding_window_view(bits, ORDER)
    assert len(np.unique(words, axis=0)) == PERIOD_BITS


def test_the_autocorrelation_has_one_peak() -> None:
    signs = 2.0 * pattern() - 1.0
    spectrum = np.abs(np.fft.fft(signs)) ** 2
    correlation = np.rint(np.fft.ifft(spectrum).real)
    assert correlation[0] == PERIOD_BITS
    assert (correlation[1:] == -1).all()


def test_the_recurrence_goes_on_over_the_end_of_the_period() -> None:
    bits = np.concatenate((pattern(), pattern()))
    n = np.arange(2 * PERIOD_BITS - ORDER)
    assert (bits[n + ORDER] == (bits[n + 3] ^ bits[n])).all()


def test_every_bit_starts_at_its_time() -> None:
    n = np.arange(3 * PERIOD_BITS)
    expected = pattern()[n % PERIOD_BITS]
    assert (lit(n * BIT_S) == expected).all()
    assert (lit((n + 0.999) * BIT_S) == expected).all()
    assert not lit(np.array([-1e-3])).any()


def test_an_exposure_sees_the_mean_of_the_light() -> None:
    random = np.random.default_rng(5)
    start = random.uniform(-0.1, 2.5 * PERIOD_BITS * BIT_S, 50)
    end = start + random.uniform(0.001, 0.2, 50)
    fine = np.array(
        [lit(np.linspace(a, b, 20001)[:-1]).mean() for a, b in zip(start, end, strict=True)]
    )
    assert np.abs(seen_share(start, end) - fine).max() < 2e-4
