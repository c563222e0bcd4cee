"""Limits by which samples of a log count as faults of its bus."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ReadErrorLimits:
    """Which samples are faults of the bus.

    A wrong read lasts at most ``longest`` samples, ``at_ends`` at either end of the recording. It
    is away from the line between its neighbours by ``acceleration`` times what any other sample of
    the recording is, by ``local`` times what the ``around`` samples on either side are, by
    ``steps`` of the encoder and by ``range_share`` of the moved range. Of it, the samples beside
    are off by less than ``return_share``, and so are its neighbours from what the speeds beside
    them make of the time between. Of the others, a share ``unresolved`` of the number of wrong
    reads may be some as well, so close together that they are not told apart. Where more than
    ``crowded`` of the samples around seem wrong, either half may be.

    Where, within ``response_s`` before, the command goes out and back as shortly and by
    ``command_share`` of it, or within ``pulse_s`` by all of it, it may be the answer. At an end of
    the recording, a command that only goes out counts too. A value that ``same_value`` wrong reads
    and a share ``same_share`` of all of them have exactly is what a read that failed returns:
    smaller ones of this value are wrong, too. Where more than ``most`` of all samples seem wrong,
    none is left out. What is away by a share ``doubt`` of what makes a read error is told where it
    stays, unless the command moves by ``answers_share`` of it.

    An old value lasts at most ``longest`` samples. The two samples on either side move in its
    direction by at least ``moving_steps`` of the encoder each. Their speeds differ by less than a
    factor ``alike``, and the mean speed across the old value from theirs by less than ``made_up``;
    or all five rise or fall in order, and that across differs so from the two nearest alone.

    A sensor is slower than the log where of at least ``held_runs`` values in quick motion a share
    ``held_alike`` stands for the same number of samples, or for one more, and at least
    ``held_share`` for more than one; the ways between them differ by a factor ``held_speeds``, and
    those of the two kinds by less than ``made_up``, as those of a servo that sticks would not. The
    command does not rest and change with the angle, in a share ``held_alike`` of these values.
    """

    longest: int = 5
    at_ends: int = 2
    crowded: float = 0.45
    doubt: float = 0.4
    answers_share: float = 0.5
    pulse_s: float = 0.1
    unresolved: float = 0.1
    same_value: int = 3
    same_share: float = 0.1
    acceleration: float = 2.0
    local: float = 5.0
    around: int = 8
    steps: float = 8.0
    range_share: float = 0.01
    return_share: float = 0.25
    command_share: float = 0.25
    response_s: float = 0.2
    most: float = 0.15
    moving_steps: float = 3.0
    alike: float = 2.5
    made_up: float = 1.3
    held_runs: int = 40
    held_alike: float = 0.95
    held_share: float = 0.2
    held_speeds: float = 2.0


LIMITS = ReadErrorLimits()
