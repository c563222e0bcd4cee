"""A supply whose voltage sags under load, and with it all that the amplifiers bring."""

from __future__ import annotations

import math

import numpy as np

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def supply(twin: Twin, values: EffectValues) -> Regulator:
    """Scale amplifiers and limits by 1 - ``sag`` [1/deg] times the filtered size of the drive.

    The filter is of first order with ``time`` [s], and sees the drive before it is scaled.
    """
    model, data = twin.model, twin.data
    tables = [model.actuator_gainprm, model.actuator_biasprm, model.actuator_forcerange]
    limits = twin.drive_range
    full = [table.copy() for table in tables]
    unit = twin.bench.torque(1.0)
    steady = 0.0  # what the filter holds [deg]
    pulled = 0.0  # what it has seen since
    seen = data.time

    def sag() -> None:
        nonlocal steady, pulled, seen
        for table, whole in zip(tables, full, strict=True):
            table[:] = whole
        steady += (pulled - steady) * -math.expm1((seen - data.time) / values["time"])
        seen = data.time
        pulled = abs(twin.drive_torque()) / unit
        half = -0.5 * model.opt.timestep / values["time"]
        scale = max(1.0 - values["sag"] * (steady + (pulled - steady) * -math.expm1(half)), 0.0)
        for table in (*tables, limits):
            np.multiply(table, scale, out=table)

    return sag


EFFECT: HiddenEffect = HiddenEffect("supply_sag", {"sag": 0.04, "time": 0.1}, supply=supply)
