"""On which side of the linkage what is missing sits: between horn and surface, or before the horn.

Between the two is what the horn's angle, and what the model misses of it, leave of the surface's
error. Before the horn is what the model misses of the horn when its gain is left open, where that
is more than a line leaves between the two: one model is fitted to both angles, and what is missing
between them, as a ratio or a lag, makes it wrong for either.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.special import gammaincc

from servosight.diagnose.residuals._judged import Judged
from servosight.diagnose.residuals.findings._finding import Case, Finding, Test, shown
from servosight.identify.problem import noise_deg
from servosight.identify.transmission import transmission
from servosight.models.core import Array, InputError, rms


def linkage_error_deg(surface: Judged, horn: Judged) -> Array:
    """What the model misses between horn and surface [deg], (samples,).

    With a model in which the two turn as one, what lines through the horn's angle and the model's
    leave of the surface's.
    """
    at_s, horn_s = surface.recording.time_s, horn.recording.time_s
    moved, missed = (
        np.interp(at_s, horn_s, one) for one in (horn.recording.angle_deg, horn.error_deg)
    )
    return _left(surface.error_deg, moved, missed)


def line_error_deg(surface: Judged, horn: Judged) -> Array:
    """What a line through the horn's angle leaves of the surface's [deg], (samples,)."""
    seen, other = surface.recording, horn.recording
    return _left(seen.angle_deg, np.interp(seen.time_s, other.time_s, other.angle_deg))


def motor_error_deg(horn: Judged) -> Array:
    """What the model misses of the horn [deg] whatever its gain, (samples,)."""
    return _left(horn.error_deg, horn.predicted_deg)


def _left(error_deg: Array, *along: Array) -> Array:
    """What a constant and multiples of (samples,) each leave of an error."""
    rows = np.column_stack([np.ones(error_deg.size), *along])
    return np.asarray(error_deg - rows @ np.linalg.lstsq(rows, error_deg)[0])


def _linkage(case: Case) -> Iterator[Finding]:
    """The linkage alone, of every run that shows both of its sides."""
    for surface, horn in zip(case.judged, case.judged[1:], strict=False):
        if horn.recording.side != "horn" or surface.recording.side == "horn":
            continue
        between, before = linkage_error_deg(surface, horn), motor_error_deg(horn)
        own = noise_deg(horn.recording)
        noise = float(np.hypot(noise_deg(surface.recording), own))
        left, model = (rms(one) for one in (between, before))
        beyond = float(np.sqrt(max(left**2 - noise**2, 0.0)))
        missing = beyond > case.floor_deg
        apart = rms(line_error_deg(surface, horn)) if missing else beyond
        total = max(float(np.mean(surface.error_deg**2)), 1e-300)
        if missing:
            yield Finding(
                test="linkage",
                sentence=f"The surface differs from the horn by {shown(left)} deg rms, where noise "
                f"allows {shown(noise)}: what is missing acts between horn and surface"
                f"{_seen(surface, horn)}.",
                size_deg=left,
                share=min(left**2 / total, 1.0),
                p=_chance(between, noise),
            )
        if model > case.floor_deg and model > apart:
            yield Finding(
                test="motor",
                sentence=f"The horn differs from the model by {shown(model)} deg rms, and the "
                f"surface from the horn by {shown(left)}: what is missing acts before the "
                f"linkage, on the motor's side.",
                size_deg=model,
                share=min(model**2 / total, 1.0),
                p=_chance(before, own),
            )


def _seen(surface: Judged, horn: Judged) -> str:
    """Ratio and play as both angles show them; nothing where they move too little for that."""
    try:
        found = transmission(surface.recording, horn.recording)
    except InputError:
        return ""
    return f" ({found.words})"


def _chance(error_deg: Array, noise: float) -> float:
    """How often noise alone is so large."""
    half = 0.5 * error_deg.size
    return float(gammaincc(half, half * np.mean(error_deg**2) / max(noise, 1e-12) ** 2))


TESTS: tuple[Test, ...] = (_linkage,)
