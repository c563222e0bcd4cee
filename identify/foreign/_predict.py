"""What an FMU predicts: the angle from the command alone."""

from __future__ import annotations

from servosight.identify.foreign._runs import Interface
from servosight.identify.foreign._surroundings import surrounded
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue
from servosight.models.plant import predict


def predict_fmu(
    interface: Interface, recording: Recording, *, from_rest: bool = False, trust: bool = False
) -> Array:
    """Angle [deg] at the recording's times, (samples,), as :func:`predict` has a card's.

    Where the FMU takes an initial state it is read off the first samples, or, with ``from_rest``,
    is at rest where the first command leads it. Raises InputError where ``trust`` is not given,
    and for whatever keeps the FMU from running.
    """
    with surrounded(interface, catalogue(), [recording], trust=trust) as model:
        return predict(
            model.actuator,
            recording,
            model.catalogue,
            initial_angle_deg=model.rest_deg if from_rest else None,
            initial_speed_deg_s=0.0 if from_rest else None,
        )
