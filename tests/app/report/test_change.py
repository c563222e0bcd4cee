"""The report of what differs between two servos."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.page import Page

import servosight as ss
from servosight.app.main import main
from servosight.diagnose.change import ComparedServo, change_between
from servosight.models.core import Actuator, Estimate
from servosight.models.effects import catalogue

UNITS = {"k": "-", "T": "s", "xi": "-", "bias": "deg"}


def card(name: str, gap_deg: float, sigma: float | None, **more: float) -> Path:
    """A model card with a play, and with other effects' parameters, of a sigma of 0.02."""
    values = {"k": (1.0, 0.001), "T": (0.02, 1e-4), "xi": (0.6, 0.01), "bias": (0.0, 0.1)}
    found = {key: Estimate(value, spread, UNITS[key]) for key, (value, spread) in values.items()}
    found["backlash.gap"] = Estimate(gap_deg, sigma, "deg")
    others = {key.replace("__", "."): Estimate(value, 0.02, "deg") for key, value in more.items()}
    effects = ("backlash", *(key.partition(".")[0] for key in others))
    Actuator({**found, **others}, effects).save(name)
    return Path(name)


def test_two_models_are_drawn_beside_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    old = card("<old>.toml", 0.31, 0.03, coulomb_friction__level=0.4)
    new = card("new.toml", 0.84, 0.04, coulomb_friction__level=0.4)
    words = ["compare", str(old), str(new), "--report", "change.html", "--json", "change.json"]
    assert main(words) == 0
    text = Path("change.html").read_text(encoding="utf-8")
    page = Page(text)
    assert page.ids[0] == "change"
    assert {"differences", "dynamics"} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert "<old>" not in text
    result = ss.load("change.json")
    assert isinstance(result, ss.ServoChange)
    for words_of in (result.headline, result.summary, *result.sentences[2:]):
        assert " ".join(words_of.split()) in page.text
    assert "backlash.gap 0.310 0.840 0.530 0.050 +10.6 deg yes" in page.text
    assert "coulomb_friction.level 0.400 0.400 0.000 0.028 +0.0 deg no" in page.text
    assert "3.5 sigma" in page.text  # of one among five
    assert "servosight compare" in page.text
    assert "error of its model" not in page.text  # of cards no recording is known
    assert main(["report", "change.json", "-o", "again.html"]) == 0
    assert Page(Path("again.html").read_text(encoding="utf-8")).ids == page.ids
    capsys.readouterr()


def test_what_cannot_be_compared_and_the_errors_of_both_are_shown(tmp_path: Path) -> None:
    models = [ss.Actuator.load(card(str(tmp_path / n), 0.3, None)) for n in ("a.toml", "b.toml")]
    sides = (
        ComparedServo(name="run", effects=("backlash",), rmse_deg=0.03, other_rmse_deg=0.25),
        ComparedServo(name="run", effects=("backlash",), rmse_deg=0.04, floor_deg=0.035),
    )
    change = change_between(models[0], models[1], catalogue=catalogue(), sides=sides)
    change.report(tmp_path / "change.html")
    page = Page((tmp_path / "change.html").read_text(encoding="utf-8"))
    assert "backlash.gap 0.3000 0.3000 0 not known – deg not known" in page.text
    assert "a: run 0.0300 deg 0.250 deg –" in page.text
    assert "b: run 0.0400 deg – 0.0350 deg" in page.text


def test_models_with_different_effects_are_shown_and_not_compared(tmp_path: Path) -> None:
    cards = (
        card(str(tmp_path / "a.toml"), 0.31, 0.03),
        card(str(tmp_path / "b.toml"), 0.84, 0.04, coulomb_friction__level=0.4),
    )
    ss.compare(*cards).report(tmp_path / "change.html")
    page = Page((tmp_path / "change.html").read_text(encoding="utf-8"))
    assert "The models hold different effects: b alone has Coulomb friction" in page.text
    assert "--effects backlash,coulomb_friction" in page.text
    assert "coulomb_friction.level – 0.400 – – – deg not known, in b alone" in page.text
