"""Add one effect to a model and fit anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.identify.fit import Identification, identify
from servosight.models.core import Actuator, InputError, Recording
from servosight.models.effects import Effect, select


def add(
    actuator: Actuator,
    effect: str,
    recordings: Sequence[Recording],
    *,
    catalogue: Mapping[str, Effect],
) -> Identification:
    """The model with one more effect, all parameters fitted to the recordings jointly.

    Raises InputError where the model has that effect already.
    """
    if effect in actuator.effects:
        raise InputError(
            f"the model has the effect {effect!r} already; expected one it lacks, so choose "
            f"another or refit with `servosight identify`"
        )
    wanted = select(catalogue, [*actuator.effects, effect])
    return identify(recordings, wanted, catalogue=catalogue, method="gradient")
