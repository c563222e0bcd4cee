"""The kernel's functions around a step: parameters, flags, states, command and step length."""

from __future__ import annotations

import ast
import inspect
import textwrap

from servosight.models.effects import Effect, Place
from servosight.models.plant.kernel._calls import Slots, any_of, function, symbol


def constants(slots: Slots) -> str:
    """How many switches there are."""
    return f"N_SWITCHES = {sum(len(effect.switches) for effect in slots.layout.effects)}"


def rows(slots: Slots) -> str:
    """A row of parameters taken apart, and the flags of what is not neutral."""
    lines = []
    for i, (effect, offset) in enumerate(
        zip(slots.layout.effects, slots.layout.offsets, strict=True)
    ):
        away = [
            f"p[{offset + j}] != {'math.inf' if q.reciprocal else repr(q.neutral)}"
            for j, q in enumerate(effect.parameters)
            if q.neutral is not None
        ]
        lines.append(f"f{i} = {' or '.join(away)}")
    # Each test has a name first: numba reads no long tuple with branches in it.
    for place in Place:
        acts = any_of([f"f{i}" for i, _ in slots.at(place)])
        lines.append(f"f{slots.any_at(place)} = {acts}")
    tests = ", ".join(f"f{i}" for i in range(len(slots.layout.effects) + len(Place)))
    row = ", ".join(f"row[{j}]" for j in range(slots.layout.width))
    more = " 0.0," if slots.layout.has_input else ""
    return "\n\n".join(
        [
            function("unpack(row)", [], f"return ({row},{more})"),
            _with_input(slots),
            function("flags(p)", lines, f"return ({tests})"),
        ]
    )


def _with_input(slots: Slots) -> str:
    """The torque of the known disturbance is computed once for each of its rows."""
    terms = [
        f"if on[{i}]:\n    torque += {symbol(e, 'term')}(value, {slots.values(i)})"
        for i, e in slots.at(Place.INPUT)
    ]
    row = ", ".join(f"p[{j}]" for j in range(slots.layout.width))
    signature = "with_input(p, on, value)"
    if not terms:
        return function(signature, [], "return p")
    return function(signature, ["torque = 0.0", *terms], f"return ({row}, torque)")


def queries(slots: Slots) -> str:
    """What the flags say of a row, for the integrator's branches."""
    varying = [i for i, e in slots.at(Place.FRICTION) if not _steady(e)]
    plant = (
        *(Place.REDUCER, Place.FEEDBACK, Place.DRIVE, Place.LOAD, Place.BRISTLE),
        Place.INPUT,
    )
    effects = list(enumerate(slots.layout.effects))
    groups = {
        "has_command_terms": [i for i, e in slots.at(Place.COMMAND) if e.term is not None],
        "has_friction": [slots.any_at(Place.FRICTION)],
        "has_varying_friction": varying,
        "has_memory": [slots.any_at(Place.TRANSMISSION)],
        "has_loop_memory": [i for i, e in effects if e.memory],
        "has_switches": [i for i, e in effects if e.switches],
        "has_resolutions": [i for i, e in effects if e.resolution is not None],
        "has_shaft": [slots.any_at(Place.SHAFT)],
        "has_states": [i for i, e in effects if e.states and e.place is not Place.COMMAND],
        "has_limited_states": [i for i, e in effects if e.state_limit is not None],
        "has_held_states": [i for i, e in slots.at(Place.DRIVE) if e.rest is not None],
        "has_input": [slots.any_at(Place.INPUT)],
        "has_plant_terms": [slots.any_at(place) for place in plant],
    }
    return "\n\n".join(
        function(f"{name}(on)", [], f"return {any_of([f'on[{i}]' for i in members])}")
        for name, members in groups.items()
    )


def states(slots: Slots) -> str:
    """States and memories: their start, sums, interpolation, and what is kept at a turn."""
    count = range(slots.n_states)
    start = ["p[4]", "p[5]"] if slots.at(Place.SHAFT) else ["0.0", "0.0"]
    start += ["0.0"] * (slots.n_states - 2)
    held = [f"z[{i}]" for i in range(slots.n_states, slots.n_slots)]
    added = ", ".join([f"z[{i}] + h * r[{i}]" for i in count] + held)
    cubics = [f"cubic(tau, h, z[{i}], r0[{i}], z1[{i}], r1[{i}])" for i in count]
    mixed = ", ".join(cubics + held)
    lines = [f"m{i} = z[{i}]" for i in range(slots.n_slots)] + ["felt = theta"]
    for i, effect in enumerate(slots.layout.effects):
        slot = slots.state[effect.id]
        if effect.place is Place.REDUCER:
            start.append("p[4]")
            call = slots.hysteresis(i, effect, "felt")
            lines.append(f"if on[{i}]:\n    felt = m{slot} = {call}")
        if effect.place is Place.BRISTLE:
            start += ["p[4]", "0.0"]
            call = slots.hysteresis(i, effect)
            lines.append(f"if on[{i}]:\n    m{slot} = theta\n    m{slot + 1} = {call}")
        if effect.state_limit is not None:
            most = slots.value(i, effect.state_limit)
            lines.append(f"if on[{i}]:\n    m{slot} = min(max(z[{slot}], -{most}), {most})")
    kept = [f"m{i}" for i in range(slots.n_slots)]
    return "\n\n".join(
        [
            function("start_states(p)", [], f"return ({', '.join(start)})"),
            function("add_scaled(z, h, r)", [], f"return ({added})"),
            function("between_states(tau, h, z, r0, z1, r1)", [], f"return ({mixed})"),
            _held(slots),
            function("keep_memory(p, on, theta, z)", lines, f"return ({', '.join(kept)})"),
        ]
    )


def _held(slots: Slots) -> str:
    """The states with which a drive that has long held a torque begins."""
    held = [f"z{i} = z[{i}]" for i in range(slots.n_slots)]
    for i, effect in slots.at(Place.DRIVE):
        if effect.rest is not None:
            first = slots.state[effect.id]
            names = ", ".join(f"z{first + j}" for j in range(effect.states))
            call = f"{symbol(effect, 'rest')}(missing, {slots.values(i)})"
            held.append(f"if on[{i}]:\n    {names} = {call}")
    kept = ", ".join(f"z{i}" for i in range(slots.n_slots))
    return function("held_states(p, on, z, missing)", held, f"return ({kept})")


def command(slots: Slots) -> str:
    """The command's delay and its terms."""
    delay, start, chain = [], [], []
    slot = 0
    for i, effect in slots.at(Place.COMMAND):
        if effect.latency is not None:
            call = f"{symbol(effect, 'latency')}({slots.values(i)})"
            delay.append(f"if on[{i}]:\n    s += {call}")
            continue
        call = symbol(effect, "term")
        own = range(slot + 1, slot + 1 + effect.states)
        kept = "".join(f"last[{j}], " for j in own)
        rates = "".join(f", s{j}" for j in own)
        names = "".join(f"v{j}, " for j in own)
        start.append("".join(f"v{j} = 0.0\n" for j in own) + f"if on[{i}]:")
        if effect.rest is not None:
            start[-1] += f"\n    {names}= {symbol(effect, 'rest')}(value, {slots.values(i)})"
        start[-1] += (
            f"\n    value = {call}(value, 0.0, 1.0, value, {names}{slots.values(i)})[0]"
            f"\nv{slot} = value"
        )
        chain.append(
            "".join(f"v{j} = last[{j}]\ns{j} = 0.0\n" for j in own)
            + f"if on[{i}]:\n    value, slope, horizon{rates} = {call}(value, slope, horizon, "
            f"last[{slot}], {kept}{slots.values(i)})\nv{slot} = value\ns{slot} = slope"
        )
        slot += 1 + effect.states
    count = range(slot)
    values = ", ".join(f"v{j}" for j in count) or "value"  # a tuple has one entry at least
    slopes = ", ".join(f"s{j}" for j in count) or "slope"
    ends = ", ".join(f"v[{j}] + s[{j}] * gone" for j in count) or "v[0]"
    return "\n\n".join(
        [
            function("latency(p, on)", ["s = 0.0", *delay], "return s"),
            function("command_start(p, on, value)", start, f"return ({values},)"),
            function(
                "command_chain(p, on, value, slope, horizon, last)",
                chain,
                f"return value, slope, horizon, ({values},), ({slopes},)",
            ),
            function("command_end(v, s, gone)", [], f"return ({ends},)"),
        ]
    )


def pace(slots: Slots) -> str:
    """The longest step that resolves all effects."""
    lines = ["s = math.inf"]
    for i, effect in enumerate(slots.layout.effects):
        if effect.resolution is None:
            continue
        at = {"T": "p[1]", "last": f"z[{slots.state[effect.id] + effect.memory - 1}]"}
        names = list(inspect.signature(effect.resolution).parameters)
        taken = names[: len(names) - len(effect.parameters)]
        motion = "".join(f"{at.get(name, name)}, " for name in taken)
        call = f"{symbol(effect, 'resolution')}({motion}{slots.values(i)})"
        lines.append(f"if on[{i}]:\n    s = min(s, {call})")
    return function("longest_step(p, on, theta, w, acceleration, z)", lines, "return s")


def _steady(friction: Effect) -> bool:
    """True where a friction term reads nothing of the motion: its size is its parameters' alone."""
    assert friction.term is not None
    tree = ast.parse(textwrap.dedent(inspect.getsource(friction.term)))
    read = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    motion = list(inspect.signature(friction.term).parameters)[:3]
    return read.isdisjoint(motion)
