"""The model card: readable, whole or not at all, and exact about what is wrong in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from servosight.models.core import Actuator, Estimate, InputError
from servosight.models.effects import catalogue

GOOD = """
format = 1
effects = ["backlash"]
[parameters]
k = { value = 1.0, sigma = 0.001, unit = "-" }
T = { value = 0.0078, unit = "s" }
xi = 0.55
bias = { value = 0.0, unit = "deg" }
"backlash.gap" = { value = 2.0, sigma = 0.01, unit = "deg" }
"""


def load(tmp_path: Path, text: str) -> Actuator:
    path = tmp_path / "card.toml"
    path.write_text(text, encoding="utf-8")
    return Actuator.load(path, catalogue())


def test_a_card_written_by_hand_is_read(tmp_path: Path) -> None:
    """Plain numbers will do, sigma may be left out; units are the catalogue's."""
    card = load(tmp_path, GOOD)
    assert card.effects == ("backlash",)
    assert card.value("xi") == 0.55
    assert card.parameters["T"] == Estimate(0.0078, None, "s")
    assert card.parameters["backlash.gap"] == Estimate(2.0, 0.01, "deg")


def test_a_value_survives_to_the_last_digit(tmp_path: Path) -> None:
    value = 1.0 / 3.0
    names = {"k": "-", "T": "s", "xi": "-", "bias": "deg"}
    card = Actuator({name: Estimate(value, value / 7, unit) for name, unit in names.items()})
    card.save(tmp_path / "card.toml")
    assert Actuator.load(tmp_path / "card.toml", catalogue()) == card


def test_an_unknown_parameter_is_asked_for_by_name(tmp_path: Path) -> None:
    with pytest.raises(KeyError):
        load(tmp_path, GOOD).value("coulomb_friction.level")


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("format = 1", "format = 9", "format"),
        ("format = 1", "format = ", "TOML"),
        ('["backlash"]', '["gremlins"]', "gremlins"),
        ('["backlash"]', '"backlash"', "list"),
        ("[parameters]", "[numbers]", "parameters"),
        ("value = 0.0078", "value = -0.01", "parameters.T.value is -0.01"),
        ("value = 0.0078", 'value = "fast"', "parameters.T.value"),
        ("value = 0.0078", "value = nan", "parameters.T.value"),
        ("value = 0.0078", "value = true", "parameters.T.value"),
        ("xi = 0.55", "", "parameters.xi.value is missing"),
        ("xi = 0.55", "xi = 0.55\nzeta = 1.0", "zeta"),
        ("sigma = 0.01", 'sigma = "none"', "parameters.backlash.gap.sigma"),
        ('effects = ["backlash"]', "", "backlash.gap"),
        ("value = 2.0", "value = 200.0", "parameters.backlash.gap.value is 200"),
    ],
)
def test_what_is_wrong_is_named_in_one_sentence(
    old: str, new: str, named: str, tmp_path: Path
) -> None:
    assert old in GOOD
    with pytest.raises(InputError) as caught:
        load(tmp_path, GOOD.replace(old, new))
    message = str(caught.value)
    assert "card.toml" in message
    assert named in message
    assert "expected" in message or "must be" in message
    assert "\n" not in message


def test_the_range_of_a_ratio_has_no_unit(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"expected 0\.02 to 20;"):
        load(tmp_path, GOOD.replace("xi = 0.55", "xi = 99"))
    with pytest.raises(InputError, match=r"expected 0\.001 to 2 s;"):
        load(tmp_path, GOOD.replace("0.0078", "99"))


def test_a_missing_card_says_how_to_get_one(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no such file.*servosight identify"):
        Actuator.load(tmp_path / "none.toml", catalogue())
    with pytest.raises(InputError, match=r"is no file.*model card"):
        Actuator.load(tmp_path, catalogue())


def test_a_card_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    """A folder that is not there leaves nothing; a second save replaces the first."""
    card = load(tmp_path, GOOD)
    with pytest.raises(InputError, match="cannot"):
        card.save(tmp_path / "nowhere" / "card.toml")
    assert not (tmp_path / "nowhere").exists()
    card.save(tmp_path / "card.toml")
    card.save(tmp_path / "card.toml")
    assert [path.name for path in tmp_path.iterdir()] == ["card.toml"]
