"""The text of ``--to c``: the plant step of one model in C99, which an FMU wraps as well."""

from __future__ import annotations

import re

from servosight.export.core import ExportRequest, filled, mark_of, number, provenance_lines
from servosight.export.csource._program import Program
from servosight.export.csource._types import ARRAY, NUMBER, TRUTH, WHOLE, Tuple, Type
from servosight.export.csource._values import literal
from servosight.models.core import CORE, OWN, Actuator, Parameter
from servosight.models.plant import Layout, kernel_source

DELAY_ROWS = 1024
"""Changes of the command under way in a dead time: a second at 1 kHz."""


def layout_of(request: ExportRequest) -> Layout:
    """Parameters and effects of the request's model, in the order of the catalogue."""
    chosen = set(request.actuator.effects)
    return Layout.of(one for name, one in request.catalogue.items() if name in chosen)


def parameters_of(layout: Layout) -> dict[str, Parameter]:
    """Name and bounds of each number of a row."""
    found = {q.name: q for q in (*CORE, *OWN)}
    return found | {f"{one.id}.{q.name}": q for one in layout.effects for q in one.parameters}


def limits_of(parameter: Parameter) -> tuple[float, ...]:
    """Bounds of a parameter and the value at which its effect vanishes, which may lie outside."""
    neutral = () if parameter.neutral is None else (parameter.neutral,)
    return parameter.low, parameter.high, *neutral


def values_of(actuator: Actuator, layout: Layout) -> list[float]:
    """The model's row: at rest at first where a command of zero leads it."""
    known = {"initial_angle": actuator.value("bias"), "initial_speed": 0.0}
    return [known[name] if name in known else actuator.value(name) for name in layout.names()]


def model_source(request: ExportRequest, name: str | None = None, kind: str = "c") -> str:
    """C99 of the model; ``name`` begins all that other files see, ``kind`` is in the mark."""
    name = name or request.name
    layout = layout_of(request)
    program = Program(kernel_source(layout.effects), name)
    words = _types(program, layout.width + layout.has_input)
    names = layout.names()
    bounds = parameters_of(layout)
    words |= {
        "mark": mark_of(kind),
        "provenance": "\n".join(f" * {line}" for line in provenance_lines(request)),
        "name": name,
        "NAME": name.upper(),
        "rows": str(DELAY_ROWS if any(one.latency for one in layout.effects) else 2),
        "indices": "\n".join(f"    {name.upper()}_{_upper(one)}," for one in names),
        "structures": "\n\n".join(program.structures.definitions()),
        "functions": program.text(),
        "names": _lines(f'"{one}"' for one in names),
        "values": _lines(_c(one) for one in values_of(request.actuator, layout)),
        "lows": _lines(_c(min(limits_of(bounds[one]))) for one in names),
        "highs": _lines(_c(max(limits_of(bounds[one]))) for one in names),
        "TINY": number(program.constants["TINY"]),
    }
    return filled("csource", "model.c", words)


def _types(program: Program, width: int) -> dict[str, str]:
    """Print what the template calls; the names of the structures that travel between."""
    name = program.structures.name
    row = Tuple((NUMBER,) * width)
    pair = Tuple((NUMBER, NUMBER))
    flags = program.need("flags", [row])
    acts = program.need("branches", [row, flags])
    own = program.need("motor", [row, flags, TRUTH])
    states = program.need("start_states", [row])
    mode = program.need("first_mode", [TRUTH, NUMBER])
    program.need("settled", [row, flags, pair, states, NUMBER])
    halves = program.need("core_updates", [NUMBER, NUMBER, NUMBER, TRUTH])
    assert isinstance(halves, Tuple)
    steps = program.need("step_lengths", [NUMBER, NUMBER])
    program.need("latency", [row, flags])
    program.need("has_command_terms", [flags])
    last = program.need("command_start", [row, flags, NUMBER])
    memory = program.need("memory_start", [NUMBER])
    program.need("reducer_angle", [row, flags, NUMBER, states])
    program.need("output_chain", [row, flags, NUMBER, memory])
    chain = program.need("command_chain", [row, flags, *[NUMBER] * 3, last])
    program.need("command_end", [last, last, NUMBER])
    motion: Type = Tuple((pair, states, mode))
    updates: Type = Tuple((*halves.items, NUMBER))
    moved = [row, flags, acts, own, steps, motion, updates]
    answer = program.need("piece", [*moved, memory, pair, pair, ARRAY, WHOLE, TRUTH, ARRAY, WHOLE])
    kinds = {
        "Row": row, "Flags": flags, "Acts": acts, "Own": own, "Pair": pair, "Motion": motion,
        "Updates": updates, "Halves": halves, "Memory": memory, "Last": last, "Chain": chain,
        "Answer": answer,
    }  # fmt: skip
    return {word: name(kind) for word, kind in kinds.items()}


def _upper(name: str) -> str:
    return re.sub(r"\W", "_", name).upper()


def _c(value: float) -> str:
    return literal(float(value)).text


def _lines(items: object) -> str:
    return "\n".join(f"    {one}," for one in items)  # type: ignore[attr-defined]
