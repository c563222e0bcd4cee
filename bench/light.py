"""The coded light: an LED in the picture that tells the time of the command's clock.

The light follows a maximal-length sequence (m-sequence) of order 10: 1023 bits of 37 ms, repeated
every 37.85 s. Any ten bits in a row occur once in a period, so that 0.4 s of video suffice to place
it, and a second, which holds 26 whole bits at least, has 16 bits to spare for errors. Its
autocorrelation is 1023 in place and -1 everywhere else (Golomb, Shift Register Sequences, 1967).

A bit lasts one to three frames at 30 to 60 frames a second. The offset is read off frames in whose
exposure the light switches, so the switchings must fall at many phases of the frames: 37 ms is no
simple multiple of a frame time, and they fall at 10 phases or more at 24, 25, 30, 50, 60, 90, 100,
120 and 240 frames a second. Bits of 40 ms would fall at one phase at 25 and at 50, at five at 30
and 60: with a short exposure the offset would then be known to 5 ms only.

The recurrence is ``b[n + 10] = b[n + 3] xor b[n]`` and starts with ten ones; the firmware has the
same in C. The light is off before the command starts and after it ends; bit 0 starts with the
command.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from servosight.models.core import Array, Mask

ORDER = 10
PERIOD_BITS = 2**ORDER - 1
BIT_S = 0.037


@cache
def pattern() -> Mask:
    """The bits of one period, (1023,): True where the light is on.

    >>> int(pattern().sum()), pattern()[:14].astype(int).tolist()
    (512, [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0])
    """
    bits = np.ones(PERIOD_BITS, dtype=bool)
    for n in range(PERIOD_BITS - ORDER):
        bits[n + ORDER] = bits[n + 3] ^ bits[n]
    bits.setflags(write=False)
    return bits


def lit(time_s: Array) -> Mask:
    """Whether the light is on at times since the start of the command, in s; same shape.

    >>> lit(np.array([-0.01, 0.0, 0.369, 0.37])).tolist()
    [False, True, True, False]
    """
    # A time that is a whole number of bits belongs to the bit that starts there.
    bit = np.floor(np.asarray(time_s) / BIT_S + 1e-9).astype(np.int64)
    return np.asarray((bit >= 0) & pattern()[bit % PERIOD_BITS])
