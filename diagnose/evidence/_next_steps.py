"""What to record next for each thing that an error depends on, with the command that makes it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from servosight.models.core import Recording

STEPS = {
    "angle": "Record slow triangles over the whole range, up and down ({command}): an error that "
    "depends on the angle alone does not change when the speed is halved.",
    "speed": "Record the same motion at half and at double the speed: friction and drag depend on "
    "the speed, a limit acts only above a certain speed.",
    "acceleration": "Record the same motion at half and at double the acceleration, and once with "
    "another load: inertia, compliance and torque limits show there.",
    "history": "Record slow triangles at two amplitudes ({command}), if possible with a rest of "
    "half a second at each turn: play, friction and hysteresis show there, and scale differently "
    "with the amplitude.",
    "amplitude": "Repeat the recording at half and at double the amplitude: an error that does "
    "not scale with it indicates friction, play or resolution; one that grows faster, a limit.",
    "time": "Repeat the recording with the servo warm, and log temperature and supply voltage.",
    "frequency": "Record a slow sweep of the frequency at two small amplitudes ({command}, and "
    "again with half the angle): an error that is the same at both is linear, such as a resonance "
    "or a delay.",
    "load": "Record the same command without load and with two known loads (relative_load in "
    "recording.toml).",
    "gain": "Record the same command at two more gains of the loop (relative_gain in "
    "recording.toml).",
    "disturbance": "Fit a run with the known disturbance as well (effect known_disturbance), or "
    "fit and test on runs without it and compare the model with this run: what remains is what "
    "the disturbance moves.",
    "stop": "Record commands that keep the servo away from its stop, or cut from the log what lies "
    "at it: no model here has a stop.",
}
"""The next step for what the error depends on most."""
SHAPES = {
    "angle": ("triangle", 1.0, "--frequency 0.1 --duration 40"),
    "history": ("triangle", 1.0, "--frequency 0.2 --duration 40"),
    "frequency": ("chirp", 0.25, "--duration 20"),
}
"""Shape of the command, share of the range that was commanded, and form: ``servosight excite``."""
RECORD_AGAIN = (
    "Record the same command three times more and diagnose all runs together: how far they differ "
    "from one another is how much of this error is chance, and the parameters become surer."
)
"""The next step where chance may be all of the error."""


def step_for(kind: str, recordings: Sequence[Recording]) -> str:
    """The next step for one of :data:`STEPS`, its command within what the recordings commanded."""
    if kind not in SHAPES:
        return STEPS[kind]
    shape, share, form = SHAPES[kind]
    low = min(float(one.command_deg.min()) for one in recordings)
    high = max(float(one.command_deg.max()) for one in recordings)
    centre = round(0.5 * (low + high), 1)
    limits = f"--angle {_below(0.5 * share * (high - low))}"
    limits += f" --centre {centre:g}" if centre else ""
    return STEPS[kind].format(command=f"`servosight excite {shape} {limits} {form} -o command.csv`")


def _below(angle_deg: float) -> str:
    """Two digits, rounded down: a command is not to reach beyond.

    >>> _below(49.9), _below(0.357)
    ('49', '0.35')
    """
    step = 10.0 ** (math.floor(math.log10(max(angle_deg, 1e-3))) - 1)
    return f"{math.floor(angle_deg / step) * step:.4g}"
