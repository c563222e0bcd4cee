"""The catalogue, choosing from it, and the user's own effects."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from servosight.models.core import InputError, Parameter
from servosight.models.effects import Effect, Place, catalogue, select
from servosight.models.effects._registry import CATALOGUE

PLUGIN = '''
from servosight.models.core import Parameter
from servosight.models.effects import Effect, Place


def term(theta: float, w: float, cubic: float) -> float:
    """A spring that hardens."""
    return cubic * theta * theta * theta


EFFECT = Effect(
    id="my_spring",
    place=Place.LOAD,
    parameters=(Parameter("cubic", "deg/deg^3", -1.0, 1.0, 0.0, "hardening"),),
    equation="load = cubic theta^3",
    looks_like="errors at the ends of the travel",
    cause="an elastic stop",
    confirm="push it by hand",
    remedy="move the stop",
    source="the user, 2024",
    starts=lambda features: ((1e-4,),),
    term=term,
)
'''


def test_the_fixed_identifiers_in_their_order() -> None:
    """Commands, files and JSON use them."""
    assert tuple(catalogue()) == CATALOGUE
    assert set(CATALOGUE) >= {
        "dead_time",
        "rate_limit",
        "torque_saturation",
        "dead_zone",
        "coulomb_friction",
        "load_dependent_friction",
        "backlash",
        "gravity_load",
        "flexible_shaft",
    }
    assert all(name == effect.id for name, effect in catalogue().items())


def test_a_choice_comes_in_the_catalogues_order_once_each() -> None:
    chosen = select(catalogue(), ["backlash", "dead_time", "backlash"])
    assert chosen == ["dead_time", "backlash"]


def test_an_unknown_effect_is_told_the_alternatives() -> None:
    with pytest.raises(InputError, match=r"'slop'.*backlash"):
        select(catalogue(), ["slop"])


def test_a_plugin_joins_behind_the_catalogue(tmp_path: Path) -> None:
    path = tmp_path / "spring.py"
    path.write_text(PLUGIN)
    assert [*catalogue([path])] == [*CATALOGUE, "my_spring"]
    assert "my_spring" not in catalogue()


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("x = 1", "no EFFECT"),
        ("import nothing_of_that_name", "ModuleNotFoundError"),
        ("def f(:", "SyntaxError"),
        (PLUGIN.replace("my_spring", "backlash"), "already in the catalogue"),
        (PLUGIN.replace("w: float, cubic", "w: float, square"), "expected (theta, w, cubic)"),
        (PLUGIN.replace("my_spring", "My Spring"), "lower-case"),
        ("EFFECTS = 5", "no EFFECT"),
        ("EFFECT = 'backlash'", "no EFFECT"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("class Own(BaseException): pass\nraise Own('mine')", "Own: mine"),
        (PLUGIN.replace("place=Place.LOAD", "place='load'"), "place is 'load'"),
        (PLUGIN.replace('source="', 'source=b"'), "source is b'"),
        (PLUGIN.replace("term=term", "term=5"), "term is 5"),
        (PLUGIN.replace("term=term", "term=max"), "term is <built-in"),
        (PLUGIN.replace("source=", "contains=('slop',), source="), "expected effects of the"),
        (
            PLUGIN.replace("source=", "contains=('backlash',), source="),
            "expected the parameters of backlash first, in units of deg",
        ),
    ],
)
def test_a_broken_plugin_is_named_in_one_sentence(text: str, named: str, tmp_path: Path) -> None:
    path = tmp_path / "spring.py"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        catalogue([path])
    assert "spring.py" in str(caught.value)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_plugin_or_one_that_is_no_python(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such plugin"):
        catalogue([tmp_path / "none.py"])
    path = tmp_path / "spring.txt"
    path.write_text(PLUGIN)
    with pytest.raises(InputError, match=r"ends in \.py"):
        catalogue([path])


def declared(**changes: object) -> Effect:
    """A small effect, with changes."""

    def term(drive: float, w: float, size: float) -> float:
        return drive * size

    fields: dict[str, object] = {
        "id": "small",
        "place": Place.DRIVE,
        "parameters": (Parameter("size", "-", 0.0, 1.0, 1.0),),
        "starts": lambda features: ((0.5,),),
        "term": term,
        **dict.fromkeys(("equation", "looks_like", "cause", "confirm", "remedy", "source"), ""),
        **changes,
    }
    return Effect(**fields)  # type: ignore[arg-type]


def test_an_effect_that_cannot_vanish_is_refused() -> None:
    with pytest.raises(InputError, match="neutral"):
        declared(parameters=(Parameter("size", "-", 0.0, 1.0),))


def test_an_effect_has_a_term_or_a_latency() -> None:
    with pytest.raises(InputError, match="exactly one"):
        declared(term=None)
    with pytest.raises(InputError, match="exactly one"):
        declared(latency=lambda size: size)


def test_a_parameter_that_an_effect_lacks_is_told_the_alternatives() -> None:
    assert declared().parameter("size").high == 1.0
    with pytest.raises(KeyError, match="size"):
        declared().parameter("width")


def test_a_parameter_with_an_infinite_neutral_is_searched_by_its_reciprocal() -> None:
    """1 / limit runs over a finite range that starts at zero, where the effect vanishes."""
    limit = Parameter("limit", "deg", 0.5, float("inf"), float("inf"))
    assert limit.reciprocal
    assert limit.search_bounds == (0.0, 2.0)
    for value in (0.5, 3.0, float("inf")):
        assert limit.from_search(limit.to_search(value)) == value
    plain = Parameter("gap", "deg", 0.0, 45.0, 0.0)
    assert plain.search_bounds == (0.0, 45.0)
    with pytest.raises(InputError, match="an infinite neutral"):
        Parameter("gap", "deg", 0.0, float("inf"), 0.0)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"name": "my gap"}, "a name of letters"),
        ({"name": "if"}, "a name of letters"),
        ({"low": 50.0}, "low is 50, expected at most high, 45"),
        ({"low": "0"}, "low is '0', expected a number"),
        ({"high": float("nan")}, "high is nan, expected a number"),
        ({"low": -float("inf")}, "expected finite"),
        ({"neutral": -3.0}, "neutral is -3, expected a value from low 0 to high 45"),
        ({"neutral": float("nan")}, "neutral is nan, expected a number"),
    ],
)
def test_a_parameter_that_no_search_can_use_is_refused(changed: dict[str, Any], said: str) -> None:
    gap = {"name": "gap", "unit": "deg", "low": 0.0, "high": 45.0, "neutral": 0.0}
    with pytest.raises(InputError, match=f"^parameter .*{said}"):
        Parameter(**{**gap, **changed})
