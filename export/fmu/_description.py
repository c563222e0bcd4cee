"""The model description: what an importer reads before it loads anything."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from xml.sax.saxutils import quoteattr

from servosight.export.core import ExportRequest, provenance_lines
from servosight.export.fmu._variables import Variable, has_exchange, variables_of

_DEGREE = math.pi / 180.0
TIME_REFERENCE = 1_000_000
_STEP_S = 1e-3
_STOP_S = 10.0


def description(request: ExportRequest, version: int, token: str) -> str:
    """``modelDescription.xml`` of FMI ``version`` 2 or 3."""
    variables = variables_of(request)
    text = "; ".join(provenance_lines(request))
    common = {
        "modelName": request.name,
        "description": f"Actuator identified from video: {text}",
        "generationTool": "servosight",
        "variableNamingConvention": "structured",
    }
    if version == 2:
        head = {"fmiVersion": "2.0", "guid": token, **common, "numberOfEventIndicators": "0"}
        body = [*_interfaces_2(request), *_units(variables), _experiment()]
        body += ["<ModelVariables>", *(_real(one, variables) for one in variables)]
        body += ["</ModelVariables>", *_structure_2(variables)]
    else:
        head = {"fmiVersion": "3.0", "instantiationToken": token, **common}
        body = [*_interfaces_3(request), *_units(variables), _experiment()]
        body += ["<ModelVariables>", *(_float(one) for one in variables), _time()]
        body += ["</ModelVariables>", *_structure_3(variables)]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f"<fmiModelDescription {_attributes(head)}>",
        *(f"  {line}" for line in body),
        "</fmiModelDescription>",
    ]
    return "\n".join(lines) + "\n"


def build_description(request: ExportRequest) -> str:
    """``sources/buildDescription.xml`` of FMI 3.0."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<fmiBuildDescription fmiVersion="3.0">\n'
        f"  <BuildConfiguration modelIdentifier={quoteattr(request.name)}>\n"
        '    <SourceFileSet language="C99">\n      <SourceFile name="fmi3.c"/>\n'
        '    </SourceFileSet>\n    <Library name="m" external="false"/>\n'
        "  </BuildConfiguration>\n</fmiBuildDescription>\n"
    )


def _attributes(found: dict[str, str]) -> str:
    return " ".join(f"{name}={quoteattr(value)}" for name, value in found.items())


def _kinds(request: ExportRequest) -> list[str]:
    return [*(["ModelExchange"] if has_exchange(request) else []), "CoSimulation"]


def _interfaces_2(request: ExportRequest) -> Iterable[str]:
    for kind in _kinds(request):
        found = {
            "modelIdentifier": request.name,
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
            "canNotUseMemoryManagementFunctions": "true",
        }
        if kind == "CoSimulation":
            found["canHandleVariableCommunicationStepSize"] = "true"
        files = '<SourceFiles><File name="fmi2.c"/></SourceFiles>'
        yield f"<{kind} {_attributes(found)}>{files}</{kind}>"


def _interfaces_3(request: ExportRequest) -> Iterable[str]:
    for kind in _kinds(request):
        found = {
            "modelIdentifier": request.name,
            "canGetAndSetFMUState": "true",
            "canSerializeFMUState": "true",
        }
        if kind == "CoSimulation":
            found["canHandleVariableCommunicationStepSize"] = "true"
        yield f"<{kind} {_attributes(found)}/>"


def _units(variables: tuple[Variable, ...]) -> list[str]:
    units = sorted({"s", *(v.attributes["unit"] for v in variables if "unit" in v.attributes)})
    return [
        "<UnitDefinitions>",
        *(f"  <Unit name={quoteattr(unit)}>{_base(unit)}</Unit>" for unit in units),
        "</UnitDefinitions>",
    ]


def _base(unit: str) -> str:
    """A unit in rad and s; products, powers and one bar of a fraction are read."""
    powers = {"rad": 0, "s": 0}
    factor = 1.0
    top, _, bottom = unit.replace("(", "").replace(")", "").partition("/")
    if "(" in unit:  # as in deg/(deg/s)^2
        found = re.fullmatch(r"(\w+)/\((\w+)/(\w+)\)\^(\d)", unit)
        if found is None:
            return ""
        first, second, third, power = found.groups()
        parts = [(first, 1), (second, -int(power)), (third, int(power))]
    else:
        parts = [(top, 1), *((one, -1) for one in bottom.split("/") if one)]
    for part, sign in parts:
        word, _, power = part.partition("^")
        count = sign * int(power or 1)
        if word == "deg":
            factor *= _DEGREE**count
            powers["rad"] += count
        elif word in powers:
            powers[word] += count
        elif word == "Hz":
            powers["s"] -= count
        elif word != "1":
            return ""
    used = {name: str(power) for name, power in powers.items() if power}
    if factor != 1.0:
        used["factor"] = repr(factor)
    return f"<BaseUnit {_attributes(used)}/>" if used else "<BaseUnit/>"


def _experiment() -> str:
    return f'<DefaultExperiment startTime="0" stopTime="{_STOP_S:g}" stepSize="{_STEP_S:g}"/>'


def _real(variable: Variable, variables: tuple[Variable, ...]) -> str:
    """FMI 2.0: what concerns all types stands outside the type, and indices count from one."""
    outer = ("causality", "variability", "initial", "description")
    found = variable.attributes
    head = {"name": variable.name, "valueReference": str(variable.reference)}
    head |= {name: found[name] for name in outer if name in found}
    inner = {name: value for name, value in found.items() if name not in outer}
    if variable.derivative_of is not None:
        inner["derivative"] = str(variable.derivative_of + 1)
    return f"  <ScalarVariable {_attributes(head)}><Real {_attributes(inner)}/></ScalarVariable>"


def _structure_2(variables: tuple[Variable, ...]) -> list[str]:
    groups = {
        "Outputs": [v for v in variables if v.output],
        "Derivatives": [v for v in variables if v.derivative_of is not None],
        "InitialUnknowns": [v for v in variables if v.calculated],
    }
    lines = ["<ModelStructure>"]
    for name, members in groups.items():
        if members:
            inner = "".join(f'<Unknown index="{v.reference + 1}"/>' for v in members)
            lines.append(f"  <{name}>{inner}</{name}>")
    return [*lines, "</ModelStructure>"]


def _float(variable: Variable) -> str:
    head = {"name": variable.name, "valueReference": str(variable.reference)}
    found = head | variable.attributes
    if variable.derivative_of is not None:
        found["derivative"] = str(variable.derivative_of)
    return f"  <Float64 {_attributes(found)}/>"


def _time() -> str:
    found = {
        "name": "time",
        "valueReference": str(TIME_REFERENCE),
        "causality": "independent",
        "variability": "continuous",
        "description": "simulation time",
        "unit": "s",
    }
    return f"  <Float64 {_attributes(found)}/>"


def _structure_3(variables: tuple[Variable, ...]) -> list[str]:
    lines = ["<ModelStructure>"]
    lines += [f'  <Output valueReference="{v.reference}"/>' for v in variables if v.output]
    lines += [
        f'  <ContinuousStateDerivative valueReference="{v.reference}"/>'
        for v in variables
        if v.derivative_of is not None
    ]
    lines += [
        f'  <InitialUnknown valueReference="{v.reference}"/>' for v in variables if v.calculated
    ]
    return [*lines, "</ModelStructure>"]
