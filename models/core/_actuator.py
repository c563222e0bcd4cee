"""The actuator: the second-order core plus effects, and its readable card."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tomli_w
from msgspec import Meta
from numpy.typing import NDArray

from servosight.models.base import InputError, Kind, either, marked_toml, read_settings, write_text
from servosight.models.core._arrays import Array
from servosight.models.core._frozen import Frozen
from servosight.models.core._parameter import CORE, OWN, Parameter
from servosight.models.core._recording import Recording
from servosight.models.core.display import frame, html_table, parameter_rows, plot_gain, uncertain
from servosight.models.schema import require, validated

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from servosight.models.effects import Effect
    from servosight.models.plant import LimitCycle

FORMAT = 1


@dataclass(frozen=True)
class Estimate:
    """A value with its standard deviation (None where it is not determined) and unit."""

    value: float
    sigma: float | None
    unit: str

    def to_json(self) -> dict[str, Any]:
        """Its JSON (docs/json.md)."""
        return {"value": self.value, "sigma": self.sigma, "unit": self.unit}


@dataclass(frozen=True, repr=False)
class Actuator(Frozen):
    """G(s) = k / (T^2 s^2 + 2 xi T s + 1) plus effects.

    ``parameters`` holds k, T, xi, bias and ``effect.parameter`` for each of ``effects``.
    ``provenance`` says what it was fitted on.

    >>> import servosight as ss
    >>> ss.identify(ss.simulate(seed=3), method="gradient").actuator.save("model.toml")
    >>> ss.Actuator.load("model.toml").effects
    ()
    """

    parameters: Mapping[str, Estimate]
    effects: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def value(self, name: str) -> float:
        """Value of a parameter; KeyError where the actuator has none of that name."""
        return self.parameters[name].value

    def to_dict(self) -> dict[str, Any]:
        """What its card holds, as plain values."""
        return {
            "format": FORMAT,
            "effects": list(self.effects),
            "parameters": {
                name: {key: value for key, value in estimate.to_json().items() if value is not None}
                for name, estimate in self.parameters.items()
            },
            "provenance": dict(self.provenance),
        }

    def save(self, path: Path | str) -> None:
        """Write the card as TOML, completely or not at all."""
        write_text(Path(path), marked_toml(Kind.MODEL, tomli_w.dumps(self.to_dict())))

    def to_frame(self) -> Any:
        """Its parameters with value, sigma and unit, as a data frame."""
        return frame(
            [{"parameter": name, **one.to_json()} for name, one in self.parameters.items()]
        )

    def linear_response(self, frequency_hz: Array) -> NDArray[np.complex128]:
        """G of the linear core at frequencies [Hz], complex, (frequencies,).

        >>> import numpy as np
        >>> from servosight.models.core import Actuator, Estimate
        >>> still = Estimate(1.0, None, "-")
        >>> card = Actuator({"k": still, "T": Estimate(0.02, None, "s"), "xi": still}, ())
        >>> float(abs(card.linear_response(np.zeros(1))[0]))
        1.0
        """
        k, T, xi = (self.value(name) for name in ("k", "T", "xi"))
        s = 2j * np.pi * np.asarray(frequency_hz)
        return np.asarray(k / (T * T * s * s + 2.0 * xi * T * s + 1.0))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Gain of the linear core over a decade about its own frequency each way, in dB."""
        decade = np.geomspace(0.1, 10.0, 200)
        frequency_hz = decade / (2.0 * np.pi * self.value("T"))
        return plot_gain(frequency_hz, self.linear_response(frequency_hz), ax)

    def predict(
        self,
        recording: Recording | Path | str | None = None,
        *,
        time_s: Any = None,
        command_deg: Any = None,
        catalogue: Mapping[str, Effect] | None = None,
    ) -> Array:
        """Angle [deg], (samples,), simulated from the command alone.

        For a recording (or its path) at its times, from its start; or for a command that holds
        between ``time_s`` (samples,), from rest. ``catalogue`` is needed for effects of a plugin.
        InputError where the times do not rise, a number is not finite, or both are given, and where
        the motion runs away.

        >>> import numpy as np
        >>> from servosight.models.core import Actuator, Estimate
        >>> act = Actuator({n: Estimate(v, None, "") for n, v in
        ...                 {"k": 1.0, "T": 0.02, "xi": 0.7, "bias": 0.0}.items()})
        >>> angle = act.predict(time_s=np.arange(0.0, 1.0, 0.01), command_deg=np.full(100, 5.0))
        >>> float(round(angle[-1], 3))
        5.0
        """
        from servosight.models.effects import catalogue as built_in  # what is above core, on use
        from servosight.models.io import command_from_arrays, load_recording
        from servosight.models.plant import (
            command_recording,
            predict,
            predict_from_rest,
            to_the_end,
        )

        known = built_in() if catalogue is None else catalogue
        given = tuple(one is not None for one in (recording, time_s, command_deg))
        if given not in ((True, False, False), (False, True, True)):
            raise InputError(
                "predict: expected one command; give a recording, or else time_s and command_deg"
            )
        if recording is None:
            rows = command_from_arrays("predict", time_s, command_deg)
            run = command_recording(*rows, rows[0])
            return to_the_end(predict_from_rest(self, run, known), run)
        if isinstance(recording, Path | str):
            recording = load_recording(recording)
        if not isinstance(recording, Recording):
            raise InputError(
                f"predict: a {type(recording).__name__} is no recording, expected a Recording or "
                f"the path of one; give arrays as time_s and command_deg"
            )
        return to_the_end(predict(self, recording, known), recording)

    def to_control(self, *, state_space: bool = False, delay_order: int = 0) -> Any:
        """The linear core k / (T^2 s^2 + 2 xi T s + 1) as a ``control.TransferFunction``.

        With ``state_space`` a ``control.StateSpace`` with the states angle [deg] and speed [deg/s].
        With a ``delay_order`` from 1 behind the dead time, where the model has one, as a Pade
        approximation of this order, whose states come last.
        """
        import control  # heavy, and needed here alone

        k, T, xi = (self.value(name) for name in ("k", "T", "xi"))
        if state_space:
            rates = [[0.0, 1.0], [-1.0 / T**2, -2.0 * xi / T]]
            core = control.ss(rates, [[0.0], [k / T**2]], [[1.0, 0.0]], [[0.0]])
        else:
            core = control.tf([k], [T * T, 2.0 * xi * T, 1.0])
        delay = self.value("dead_time.delay") if "dead_time" in self.effects else 0.0
        if delay_order < 1 or delay == 0.0:
            return core
        late = control.tf(*control.pade(delay, delay_order))
        return control.series(control.tf2ss(late) if state_space else late, core)

    def describing_function(
        self,
        amplitude_deg: float,
        frequency_hz: float,
        *,
        offset_deg: float = 0.0,
        catalogue: Mapping[str, Effect] | None = None,
    ) -> complex:
        """Gain and phase of the model, all effects included, for a sine of the command.

        The first harmonic of the angle over that of a command of ``amplitude_deg`` about
        ``offset_deg``, by simulation. Raises InputError for an amplitude or a frequency of 0.
        """
        from servosight.models.effects import catalogue as built_in
        from servosight.models.plant import describing_function

        known = built_in() if catalogue is None else catalogue
        return describing_function(self, amplitude_deg, frequency_hz, known, offset_deg=offset_deg)

    def limit_cycles(
        self,
        loop: Callable[[complex], complex],
        *,
        amplitudes_deg: tuple[float, float] | None = None,
        frequencies_hz: tuple[float, float] | None = None,
        catalogue: Mapping[str, Effect] | None = None,
    ) -> tuple[LimitCycle, ...]:
        """Oscillations that a loop around the servo sustains, the slowest first.

        ``loop`` is the rest of the loop, from the angle to minus the command: controller times
        vehicle, as a ``control.TransferFunction`` or any function of s [rad/s]. Searched for
        commands of ``amplitudes_deg`` (default 0.05 to 40) at ``frequencies_hz`` (default 0.02 to 2
        times the natural frequency). By harmonic balance, so to be confirmed by simulation.
        """
        from servosight.models.effects import catalogue as built_in
        from servosight.models.plant import limit_cycles

        known = built_in() if catalogue is None else catalogue
        return limit_cycles(
            self, loop, known, amplitudes_deg=amplitudes_deg, frequencies_hz=frequencies_hz
        )

    def __repr__(self) -> str:
        """Core and effects in one line."""
        core = ", ".join(
            f"{name} {uncertain(one.value, one.sigma)[0]}"
            for name, one in self.parameters.items()
            if "." not in name
        )
        return f"<Actuator: {core}; {', '.join(self.effects) or 'linear'}>"

    def _repr_html_(self) -> str:
        return html_table(parameter_rows(self.parameters), f"{self!r}"[1:-1])

    @classmethod
    def load(cls, path: Path | str, effects: Mapping[str, Effect] | None = None) -> Actuator:
        """Read a card; InputError names the key that is wrong and what was expected.

        ``effects`` is the catalogue (default: the built-in one).
        """
        path = Path(path)
        if effects is None:
            from servosight.models.effects import catalogue  # what is above core, on use

            effects = catalogue()
        card = read_settings(path, "a model card as `servosight identify -o MODEL.toml` writes it")
        return _read(path, card, effects)


@dataclass(frozen=True)
class _Entry:
    """A parameter as a card holds it."""

    value: float
    sigma: float | None = None


@dataclass(frozen=True)
class _Card:
    """The keys of a model card."""

    format: Annotated[
        int,
        Meta(
            ge=FORMAT,
            le=FORMAT,
            description=str(FORMAT),
            extra={"fix": "write the card anew with `servosight identify`"},
        ),
    ]
    parameters: Annotated[
        Mapping[str, float | Mapping[str, Any]],
        Meta(
            description="a table with k, T, xi and bias",
            extra={"fix": "write the card anew with `servosight identify`"},
        ),
    ]
    effects: Annotated[
        tuple[str, ...], Meta(description="a list of effect ids, such as ['backlash']")
    ] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)


def _read(path: Path, table: dict[str, Any], effects: Mapping[str, Effect]) -> Actuator:
    card = validated(table, _Card, path, notes=True)
    for name in card.effects:
        if name not in effects:
            raise InputError(
                f"{path}: key effects names {name!r}, expected one of {', '.join(effects)}; "
                f"bring your own with {either('plugins=[FILE.py]', '--plugin FILE.py')}"
            )
    wanted = {parameter.name: parameter for parameter in (*CORE, OWN[0])}
    for name in card.effects:
        wanted |= {f"{name}.{q.name}": q for q in effects[name].parameters}
    for name in card.parameters:
        if name not in wanted:
            raise InputError(
                f"{path}: unknown parameter {name!r}, expected {', '.join(wanted)}; remove it or "
                f"add its effect to the key effects"
            )
    estimates = {
        name: _estimate(path, f"parameters.{name}", card.parameters.get(name, {}), q)
        for name, q in wanted.items()
    }
    return Actuator(estimates, card.effects, card.provenance)


def _estimate(path: Path, key: str, entry: float | Mapping[str, Any], q: Parameter) -> Estimate:
    """A parameter's estimate; a bare number is its value."""
    read = validated(
        entry if isinstance(entry, Mapping) else {"value": entry}, _Entry, path, key, notes=True
    )
    require(q.low <= read.value <= q.high, path, f"{key}.value", read.value, q.range_words)
    return Estimate(read.value, read.sigma, q.unit)
