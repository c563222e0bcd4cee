"""The kernel's functions within a step: torques and kinks, friction, the surface's angle."""

from __future__ import annotations

from servosight.models.effects import Effect, Place
from servosight.models.plant.kernel._calls import Slots, function, symbol


def _reducer(slots: Slots) -> list[str]:
    """Lines that compute the angle behind the reducer, ``felt``."""
    chain = [
        f"if on[{i}]:\n    felt = {slots.hysteresis(i, effect, 'felt')}"
        for i, effect in slots.at(Place.REDUCER)
    ]
    return ["felt = theta", *slots.guarded(Place.REDUCER, chain)]


def _feedback(slots: Slots) -> list[str]:
    """Lines that compute ``e`` from force and ``felt`` through the feedback terms."""
    lines = []
    for i, effect in slots.at(Place.FEEDBACK):
        call = f"{symbol(effect, 'term')}(felt, {slots.values(i)})"
        lines.append(f"if on[{i}]:\n    felt = {call}")
    return [*slots.guarded(Place.FEEDBACK, lines), "e = force - felt"]


def _load(slots: Slots) -> list[str]:
    """Lines that sum the torques on the motor's side, ``load``."""
    loads = [slots.stateful(i, f, "theta, w", "load", "+=") for i, f in slots.at(Place.LOAD)]
    bristles = [
        f"if on[{i}]:\n    load += {slots.hysteresis(i, effect)}"
        for i, effect in slots.at(Place.BRISTLE)
    ]
    pushed = f" - p[{slots.layout.width}]" if slots.layout.has_input else ""
    return [
        f"load = 0.0{pushed}",
        *slots.guarded(Place.LOAD, loads),
        *slots.guarded(Place.BRISTLE, bristles),
    ]


def torques(slots: Slots) -> str:
    """What acts on the motor at an instant, the rates of all states, and each switch's number.

    A switch stands ahead of its own term.
    """
    rates = [f"r{i}" for i in range(slots.n_states)]
    lines = [f"{rate} = 0.0" for rate in rates]
    names: list[str] = []

    def watch(index: int, effect: Effect, leading: str) -> None:
        first = slots.state[effect.id]
        kept = "".join(f"z[{first + j}], " for j in range(effect.states + effect.memory))
        for role in effect.switches:
            name = f"g{len(names)}"
            call = f"{symbol(effect, role)}({leading}, {kept}{slots.values(index)})"
            lines.append(f"{name} = 1.0\nif on[{index}]:\n    {name} = {call}")
            names.append(name)

    lines.append("felt = theta")
    for i, effect in slots.at(Place.REDUCER):
        watch(i, effect, "felt")
        lines.append(f"if on[{i}]:\n    felt = {slots.hysteresis(i, effect, 'felt')}")
    lines += _feedback(slots)
    for i, effect in slots.at(Place.DRIVE):
        watch(i, effect, "e, w")
        lines.append(slots.stateful(i, effect, "e, w", "e", "="))
    lines += _load(slots)
    lines.append("ahead = -1.0 if mode < 0 else 1.0")
    for i, effect in slots.at(Place.FRICTION):
        watch(i, effect, "ahead * w, ahead * e, ahead * load")
    lines.append("reaction = 0.0\nshare = 0.0")
    for i, effect in slots.at(Place.SHAFT):
        call = f"{symbol(effect, 'term')}(theta, w, p[1], z[0], z[1], {slots.values(i)})"
        lines.append(f"if on[{i}]:\n    reaction, share, r0, r1 = {call}")
    rates += ["0.0"] * (slots.n_slots - slots.n_states)
    end = f"return e, load, reaction, share, ({', '.join(rates)}), ({', '.join([*names, '1.0'])},)"
    return function("torques(p, on, force, theta, w, z, mode)", lines, end)


def friction(slots: Slots) -> str:
    """The size of all friction."""
    terms = [
        f"if on[{i}]:\n    size += {symbol(e, 'term')}(speed, drive, load, {slots.values(i)})"
        for i, e in slots.at(Place.FRICTION)
    ]
    lines = ["size = 0.0", *terms]
    return function("friction_size(p, on, speed, drive, load)", lines, "return size")


def output(slots: Slots) -> str:
    """The angle behind the reducer and behind the transmission, and what the latter remembers."""
    show, keep = [], []
    terms = slots.at(Place.TRANSMISSION)
    for slot, (i, effect) in enumerate(terms):
        line = f"angle = {symbol(effect, 'term')}(angle, memory[{slot}], {slots.values(i)})"
        show.append(f"if on[{i}]:\n    {line}")
        keep.append(f"if on[{i}]:\n    {line}\nm{slot} = angle")
    count = max(len(terms), 1)  # a tuple has one entry at least
    kept = ", ".join(f"m{slot}" for slot in range(len(terms))) or "angle"
    return "\n\n".join(
        [
            function("reducer_angle(p, on, theta, z)", _reducer(slots), "return felt"),
            function(
                "output_chain(p, on, angle, memory)",
                slots.guarded(Place.TRANSMISSION, show),
                "return angle",
            ),
            function("memory_start(angle)", [], f"return ({'angle, ' * count})"),
            function("memory_commit(p, on, angle, memory)", keep, f"return ({kept},)"),
        ]
    )
