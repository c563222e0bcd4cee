"""On which side of the linkage what is missing sits: the surface against the horn.

Both are seen in one video, so no model comes into it: where the surface follows the horn along a
line, nothing between the two is missing.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.special import gammaincc

from servosight.diagnose.residuals._judged import Judged
from servosight.diagnose.residuals.findings._finding import Case, Finding, Test
from servosight.identify.problem import noise_deg
from servosight.models.core import Array


def linkage_error_deg(surface: Judged, horn: Judged) -> Array:
    """What a line through the horn's angle leaves of the surface's [deg], (samples,)."""
    seen, other = surface.recording, horn.recording
    moved = np.interp(seen.time_s, other.time_s, other.angle_deg)
    slope, zero = np.polyfit(moved, seen.angle_deg, 1)
    return np.asarray(seen.angle_deg - slope * moved - zero)


def _linkage(case: Case) -> Iterator[Finding]:
    """The linkage alone, of every run that shows both of its sides."""
    for surface, horn in zip(case.judged, case.judged[1:], strict=False):
        if horn.recording.side != "horn" or surface.recording.side == "horn":
            continue
        between = linkage_error_deg(surface, horn)
        noise = float(np.hypot(noise_deg(surface.recording), noise_deg(horn.recording)))
        left = float(np.sqrt(np.mean(between**2)))
        model = float(np.sqrt(np.mean(horn.error_deg**2)))
        beyond = np.sqrt(max(left**2 - noise**2, 0.0))
        total = max(float(np.mean(surface.error_deg**2)), 1e-300)
        if beyond > case.floor_deg:
            yield Finding(
                test="linkage",
                sentence=f"The surface differs from the horn by {left:.2g} deg rms, where noise "
                f"allows {noise:.2g}: what is missing acts between horn and surface.",
                size_deg=left,
                share=min(left**2 / total, 1.0),
                p=_chance(between, noise),
            )
        if model > case.floor_deg and model > beyond:
            yield Finding(
                test="motor",
                sentence=f"The horn differs from the model by {model:.2g} deg rms, and the surface "
                f"from the horn by {left:.2g}: what is missing acts before the linkage, on the "
                f"motor's side.",
                size_deg=model,
                share=min(model**2 / total, 1.0),
                p=_chance(horn.error_deg, noise_deg(horn.recording)),
            )


def _chance(error_deg: Array, noise: float) -> float:
    """How often noise alone is so large."""
    half = 0.5 * error_deg.size
    return float(gammaincc(half, half * np.mean(error_deg**2) / max(noise, 1e-12) ** 2))


TESTS: tuple[Test, ...] = (_linkage,)
