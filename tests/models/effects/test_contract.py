"""The contract of an effect: what each place asks of its functions, checked at the declaration."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from servosight.models.core import InputError, Parameter
from servosight.models.effects import SIGNATURES, Effect, Place
from servosight.models.plant import Layout, Plant, Stimulus

OUTSIDE = 2.0


def declared(place: Place, term: Callable[..., Any] | None, **changes: Any) -> Effect:
    """An effect with one parameter ``size``, neutral at 0, and no words."""
    words = ("equation", "looks_like", "cause", "confirm", "remedy", "source")
    fields: dict[str, Any] = {
        "id": "tried",
        "place": place,
        "parameters": (Parameter("size", "-", 0.0, 1.0, 0.0),),
        "starts": lambda features: ((0.5,),),
        "term": term,
        **dict.fromkeys(words, ""),
        **changes,
    }
    return Effect(**fields)


def command(value: float, slope: float, horizon: float, last: float, size: float) -> Any:
    return value + size, slope, horizon


def reducer(theta: float, last: float, size: float) -> float:
    return theta + size * last


def feedback(theta: float, size: float) -> float:
    return theta + size


def drive(drive: float, w: float, size: float) -> float:
    return drive * (1.0 - size)


def friction(speed: float, drive: float, load: float, size: float) -> float:
    return size


def bristle(theta: float, start: float, last: float, size: float) -> float:
    return size * (theta - start)


def load(theta: float, w: float, size: float) -> float:
    return size * theta


def shaft(theta: float, w: float, T: float, far_theta: float, far_w: float, size: float) -> Any:
    return 0.0, 0.0, far_w, size * (theta - far_theta)


def transmission(angle: float, last: float, size: float) -> float:
    return angle - size * last


def pushed(disturbance: float, size: float) -> float:
    return size * disturbance


RIGHT = dict(
    zip(
        Place,
        (command, reducer, feedback, drive, friction, bristle, load, shaft, transmission, pushed),
        strict=True,
    )
)


@pytest.mark.parametrize("place", Place)
def test_every_place_takes_its_own_signature_and_no_other(place: Place) -> None:
    """Of the ten functions, each fits its own place; what differs in arity fits no other."""
    states = 2 if place is Place.SHAFT else 0
    assert declared(place, RIGHT[place], states=states).place is place
    for other, term in RIGHT.items():
        if len(SIGNATURES[other].leading) == len(SIGNATURES[place].leading):
            continue
        with pytest.raises(InputError) as caught:
            declared(place, term, states=states)
        said = str(caught.value)
        assert "effect tried" in said
        assert place.value in said
        assert f"expected ({', '.join(SIGNATURES[place].leading)}, size)" in said


def _speedless(theta: float, size: float) -> float:
    return size * theta


def _swapped(w: float, theta: float, size: float) -> float:
    return size * theta


def _global(theta: float, w: float, size: float) -> float:
    return OUTSIDE * size * theta


def _builtin(theta: float, w: float, size: float) -> float:
    return size * float(open("table").read())


def _unknown(theta: float, w: float, size: float) -> float:
    return size * thteta  # type: ignore[name-defined]  # noqa: F821


def _starred(*values: float) -> float:
    return 0.0


def _pair(theta: float, w: float, size: float) -> tuple[float, float]:
    return size, theta


def _text(theta: float, w: float, size: float) -> str:
    return "much"


def _nothing(theta: float, w: float, size: float) -> None:
    size *= 2.0


def _fails(theta: float, w: float, size: float) -> float:
    return size * math.sqrt(-1.0 - theta)


def _later(theta: float, w: float, size: float) -> float | None:
    return size * theta if size < 0.01 else None


def _imports(theta: float, w: float, size: float) -> float:
    import cmath

    return size * cmath.pi


def _writes(theta: float, w: float, size: float) -> float:
    global OUTSIDE
    OUTSIDE = 3.0
    return size * OUTSIDE


def _default(theta: float, w: float, size: float = 2.0) -> float:
    return size * theta


def _truth(theta: float, w: float, size: float) -> bool:
    return size > 0.5


def _stays(theta: float, w: float, size: float) -> float:
    return 1.0 + size * theta


@pytest.mark.parametrize(
    ("term", "said"),
    [
        (_speedless, "expected (theta, w, size)"),
        (_swapped, "expected (theta, w, size)"),
        (_global, "uses OUTSIDE"),
        (_builtin, "uses open"),
        (_unknown, "uses thteta"),
        (_starred, "expected (theta, w, size)"),
        (lambda theta, w, size: size * theta, "defined with def"),
        (_pair, "one number"),
        (_text, "one number"),
        (_nothing, "one number"),
        (_fails, "ValueError"),
        (_later, "at (3, 30, 0.25) returns None"),
        (_imports, "import cmath"),
        (_writes, "global OUTSIDE"),
        (_default, "takes (theta, w, size=2.0)"),
        (_truth, "one number"),
        (_stays, "vanishes"),
    ],
)
def test_a_load_that_no_kernel_can_use_is_refused(term: Callable[..., Any], said: str) -> None:
    """One sentence with effect, place, role and what is wrong."""
    with pytest.raises(InputError) as caught:
        declared(Place.LOAD, term)
    for word in ("effect tried (load): term", said):
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_closure_is_refused() -> None:
    """The kernel has no variables of a function around the term."""
    factor = 3.0

    def term(theta: float, w: float, size: float) -> float:
        return factor * size * theta

    with pytest.raises(InputError, match="uses factor"):
        declared(Place.LOAD, term)


def test_states_latencies_and_switches_stand_where_the_kernel_has_them() -> None:
    def delay(size: float) -> float:
        return size

    def corner(theta: float, w: float, size: float) -> float:
        return theta

    def lagged(theta: float, w: float, state: float, size: float) -> tuple[float, float]:
        return size * state, theta - state

    def ramped(
        value: float, slope: float, horizon: float, last: float, state: float, size: float
    ) -> tuple[float, float, float, float]:
        return last, state, horizon, size

    assert declared(Place.COMMAND, None, latency=delay).latency is delay
    assert declared(Place.LOAD, lagged, states=1).states == 1
    assert declared(Place.COMMAND, ramped, states=1).states == 1

    def begun(value: float, size: float) -> float:
        return value

    assert declared(Place.COMMAND, ramped, states=1, rest=begun).rest is begun

    def held(drive: float, w: float, state: float, size: float) -> tuple[float, float]:
        return drive + size * state, drive

    def wound(missing: float, size: float) -> float:
        return missing

    assert declared(Place.DRIVE, held, states=1, rest=wound).rest is wound
    with pytest.raises(InputError, match="no rest"):
        declared(Place.LOAD, lagged, states=1, rest=begun)
    with pytest.raises(InputError, match="no latency"):
        declared(Place.LOAD, None, latency=delay)
    with pytest.raises(InputError, match="no switch"):
        declared(Place.LOAD, load, switch=corner)
    with pytest.raises(InputError, match="no state"):
        declared(Place.FEEDBACK, feedback, states=1)

    def still(theta: float, w: float, state: float, size: float) -> float:
        return size * state

    with pytest.raises(InputError, match="a tuple of 2 numbers"):
        declared(Place.LOAD, still, states=1)


def test_what_it_returns_lies_where_the_integrator_needs_it() -> None:
    """No friction that pushes, no step backwards."""

    def pushes(speed: float, drive: float, load: float, size: float) -> float:
        return -size

    def back(
        value: float, slope: float, horizon: float, last: float, size: float
    ) -> tuple[float, float, float]:
        return value, slope, -horizon

    with pytest.raises(InputError, match="as its magnitude, expected at least 0"):
        declared(Place.FRICTION, pushes)
    with pytest.raises(InputError, match="as its horizon, expected at least 0"):
        declared(Place.COMMAND, back)


@pytest.mark.parametrize(
    ("guesses", "said"),
    [
        (None, "returns None"),
        ((0.5,), "returns \\(0.5,\\)"),
        (((0.5, 0.5),), "finite numbers for \\(size\\)"),
        (((math.nan,),), "finite numbers"),
    ],
)
def test_guesses_have_a_number_for_each_parameter(guesses: Any, said: str) -> None:
    with pytest.raises(InputError, match=f"starts .*{said}"):
        declared(Place.LOAD, load, starts=lambda features: guesses)
    with pytest.raises(InputError, match=r"starts fails .*ZeroDivisionError"):
        declared(Place.LOAD, load, starts=lambda features: 1 / 0)


def test_what_numba_cannot_compile_is_one_sentence() -> None:
    """Python that runs alone and does not compile: the effect is named, not numba's traceback."""

    def term(theta: float, w: float, size: float) -> float:
        return math.fsum((size, 0.0 * theta))

    plant = Plant.of({"tried": declared(Place.LOAD, term)})
    row = np.array(Layout.of(plant.layout.effects).neutral_row())
    times = np.linspace(0.0, 0.1, 11)
    with pytest.raises(InputError, match=r"effect tried \(load\): term cannot be compiled"):
        plant.simulate(row, Stimulus(times, times, False, times, np.ones(1)))


@pytest.mark.parametrize(
    ("field", "given"),
    [
        *(("lead", "speed"), ("lead", 3), ("state_limit", "speed")),
        *(("least_share", 1.5), ("least_share", "a third")),
    ],
)
def test_lead_and_limit_are_parameters_and_what_is_to_be_promised_a_share(
    field: str, given: Any
) -> None:
    with pytest.raises(InputError, match=f"effect .?tried.?: {field} is "):
        declared(Place.LOAD, load, **{field: given})
