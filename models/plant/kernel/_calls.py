"""How the kernel calls an effect's functions: with which parameters, states and memory."""

from __future__ import annotations

import textwrap

from servosight.models.core import InputError
from servosight.models.effects import Effect, Place
from servosight.models.plant.kernel._layout import Layout


class Slots:
    """Where each effect's states and memory stand, and how its functions are called with them."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.state: dict[str, int] = {}
        count = 0
        # The shaft's two states come first: the integrator reads the far angle from them. What a
        # term remembers from one turn of the motor to the next stands behind all states.
        for effect in sorted(layout.effects, key=lambda effect: effect.place is not Place.SHAFT):
            self.state[effect.id] = count
            if effect.place is not Place.COMMAND:  # a command term's stand beside its last output
                count += effect.states
        self.n_states = count = max(count, 2)
        for effect in layout.effects:
            if effect.memory:
                self.state[effect.id] = count
                count += effect.memory
        self.n_slots = count
        shafts = self.at(Place.SHAFT)
        if len(shafts) > 1:
            names = [effect.id for _, effect in shafts]
            raise InputError(f"effects {names}: expected at most one second inertia; leave one out")

    def at(self, place: Place) -> list[tuple[int, Effect]]:
        """Index and effect of those that act at a place."""
        return [(i, e) for i, e in enumerate(self.layout.effects) if e.place is place]

    def any_at(self, place: Place) -> int:
        """Where the flags say that an effect acts at a place; behind those of the effects."""
        return len(self.layout.effects) + list(Place).index(place)

    def guarded(self, place: Place, lines: list[str]) -> list[str]:
        """Lines that are passed over where nothing acts at a place."""
        if not lines:
            return []
        return [f"if on[{self.any_at(place)}]:\n" + textwrap.indent("\n".join(lines), "    ")]

    def values(self, index: int) -> str:
        """The effect's parameters as arguments."""
        start = self.layout.offsets[index]
        count = len(self.layout.effects[index].parameters)
        return ", ".join(f"p[{start + j}]" for j in range(count))

    def value(self, index: int, name: str) -> str:
        """One of the effect's parameters."""
        names = [parameter.name for parameter in self.layout.effects[index].parameters]
        return f"p[{self.layout.offsets[index] + names.index(name)}]"

    def hysteresis(self, index: int, effect: Effect, angle: str = "theta") -> str:
        """A call of a term that remembers the last turn of the motor."""
        first = self.state[effect.id]
        kept = "".join(f"z[{first + j}], " for j in range(effect.memory))
        return f"{symbol(effect, 'term')}({angle}, {kept}{self.values(index)})"

    def stateful(self, index: int, effect: Effect, leading: str, target: str, sign: str) -> str:
        """A call whose term may own states; their rates are ``r0``, ``r1``, ..."""
        first = self.state[effect.id]
        states = "".join(f"z[{first + j}], " for j in range(effect.states))
        call = f"{symbol(effect, 'term')}({leading}, {states}{self.values(index)})"
        if not effect.states:
            return f"if on[{index}]:\n    {target} {sign} {call}"
        rates = ", ".join(f"r{first + j}" for j in range(effect.states))
        return f"if on[{index}]:\n    value, {rates} = {call}\n    {target} {sign} value"


def symbol(effect: Effect, role: str) -> str:
    """The name of an effect's function in the kernel."""
    return f"{effect.id}__{role}"


def any_of(names: list[str]) -> str:
    """An expression that is true where one of the names is."""
    return " or ".join(names) or "False"


def function(signature: str, lines: list[str], end: str) -> str:
    """A compiled function's text."""
    body = textwrap.indent("\n".join([*lines, end]), "    ")
    return f"@njit\ndef {signature}:\n{body}"
