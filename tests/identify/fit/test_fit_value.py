"""Fit as a value: its JSON and back, its card, and what a notebook asks of it."""

from __future__ import annotations

import json
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import Fit, identify, with_information
from servosight.models.core import Actuator, Estimate
from servosight.models.effects import catalogue


@pytest.fixture(scope="module")
def fit(record: Any) -> Fit:
    """Two recordings, an effect that they do not determine among the parameters."""
    recordings = [record(4.0, 3), record(3.0, 4)]
    return with_information(
        identify(recordings, ["torque_saturation"], method="gradient"), recordings
    )


def test_json_and_back(fit: Fit, tmp_path: Path) -> None:
    table = json.loads(json.dumps(fit.to_dict(), allow_nan=False))
    assert Fit.from_dict(table) == fit
    fit.save(tmp_path / "fit.json")
    assert Fit.load(tmp_path / "fit.json") == fit


def test_it_is_frozen(fit: Fit) -> None:
    with pytest.raises(FrozenInstanceError):
        fit.rmse_deg = 0.0  # type: ignore[misc]


def test_covariance_agrees_with_the_sigmas(fit: Fit) -> None:
    """Null where a parameter has no sigma; else its diagonal is sigma squared."""
    assert fit.covariance.names == ("k", "T", "xi", "torque_saturation.limit")
    for name, variance in zip(fit.covariance.names, np.diag(fit.covariance.values), strict=True):
        one = fit.parameters[name]
        assert isinstance(one, Estimate)
        if one.sigma is None:
            assert np.isnan(variance)
        else:
            assert np.sqrt(variance) == pytest.approx(one.sigma)
    assert fit.parameters["torque_saturation.limit"].sigma is None  # type: ignore[union-attr]
    assert np.nanmax(np.abs(fit.correlation.values)) == pytest.approx(1.0)


def test_the_card_of_a_fit(fit: Fit, tmp_path: Path) -> None:
    fit.save(tmp_path / "model.toml")
    read = Actuator.load(tmp_path / "model.toml", catalogue())
    assert read.parameters == fit.actuator.parameters
    assert read.effects == ("torque_saturation",)
    assert fit.biases == fit.parameters["bias"]


def test_what_the_command_does_not_determine_is_a_warning(fit: Fit) -> None:
    assert fit.information is not None
    assert not fit.information.sufficient
    assert fit.information.sentence in fit.warnings
