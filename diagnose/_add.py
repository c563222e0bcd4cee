"""Add one effect to a model and fit anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.identify.fit import Fit, identify
from servosight.models.core import Actuator, InputError, Recording
from servosight.models.effects import Effect, select
from servosight.models.effects import catalogue as built_in


def add(
    actuator: Actuator,
    effect: str,
    recordings: Sequence[Recording],
    *,
    catalogue: Mapping[str, Effect] | None = None,
) -> Fit:
    """The model with one more effect, all parameters fitted to the recordings jointly.

    Raises InputError where the model has that effect already.
    """
    effects = built_in() if catalogue is None else catalogue
    if effect in actuator.effects:
        raise InputError(
            f"the model has the effect {effect!r} already; expected one it lacks, so choose "
            f"another or refit with `servosight identify`"
        )
    wanted = select(effects, [*actuator.effects, effect])
    return identify(recordings, wanted, catalogue=effects, method="gradient")
