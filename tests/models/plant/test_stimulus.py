"""Stimuli that ask the same have one digest, others have another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.models.plant import Stimulus

TIMES = np.linspace(0.0, 1.0, 5)
STIMULUS = Stimulus(TIMES, np.sin(TIMES), False, TIMES, np.ones(1))


def test_the_digest_tells_stimuli_apart() -> None:
    same = Stimulus(TIMES.copy(), np.sin(TIMES), False, TIMES, np.ones(1))
    others = (
        replace(STIMULUS, linear=True),
        replace(STIMULUS, horn=True),
        replace(STIMULUS, command_deg=np.cos(TIMES)),
        replace(STIMULUS, samples_s=TIMES[1:]),
        replace(STIMULUS, weights=np.full(1, 0.5)),
        replace(STIMULUS, disturbance=np.ones((2, 1))),
        replace(STIMULUS, restarts=np.ones((3, 1))),
    )
    assert same.digest == STIMULUS.digest
    assert len({one.digest for one in (STIMULUS, *others)}) == 1 + len(others)
