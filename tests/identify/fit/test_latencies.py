"""Recordings with latencies of their own, on the twin: found, said, and corrected.

Truth: two runs of one servo with dead times of 4 and 12 ms, which differ by 8 ms. The bound is 3
sigma of the found difference and 2 % for the sampling of both runs.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from servosight.identify.fit import identify
from servosight.models.core import Recording
from servosight.models.io import load_recording, save_recording
from servosight.scenarios.produce import simulated
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings

NOISE_DEG = 0.03
LATE_MS = 8.0


def run(seed: int, delay_s: float) -> Recording:
    return simulated(
        Scenario(
            seed=seed,
            duration_s=8.0,
            noise_deg=NOISE_DEG,
            motion=CommandSettings(amplitude_deg=15.0),
            effects={"dead_time": {"delay": delay_s}},
        )
    )


@pytest.mark.parametrize("effects", [(), ("dead_time",)])
def test_the_later_recording_is_named_and_its_latency_corrects_the_fit(
    effects: tuple[str, ...], tmp_path: Path
) -> None:
    for name, one in (("early", run(1, 0.004)), ("late", run(2, 0.012))):
        save_recording(one, tmp_path / name)
    pair = [load_recording(tmp_path / name) for name in ("early", "late")]
    fit = identify(pair, effects, method="gradient")
    (note,) = (one for one in fit.warnings if "later after the command" in one)
    found = re.search(
        r"^late: its angle comes ([\d.]+) \+- ([\d.]+) ms.*latency_s = (\S+) in", note
    )
    assert found is not None, note
    late, sigma = float(found[1]), float(found[2])
    print(f"truth {LATE_MS} ms, found {late} +- {sigma} ms; rmse {fit.rmse_deg:.4f} deg")
    assert abs(late - LATE_MS) <= 3.0 * sigma + 0.02 * LATE_MS
    assert fit.rmse_deg > 2.0 * NOISE_DEG

    settings = tmp_path / "late" / "recording.toml"
    settings.write_text(f"latency_s = {found[3]}\n" + settings.read_text())
    corrected = load_recording(tmp_path / "late")
    again = identify([pair[0], corrected], ["dead_time"], method="gradient")
    assert not any("later after the command" in one for one in again.warnings)
    assert again.rmse_deg < 1.1 * NOISE_DEG
    delay = again.parameters["dead_time.delay"]
    assert delay.sigma is not None
    assert abs(delay.value - 0.004) <= 3.0 * delay.sigma + 2e-4
    save_recording(corrected, tmp_path / "again")
    assert load_recording(tmp_path / "again").time_s == pytest.approx(corrected.time_s)


def test_recordings_of_one_latency_are_not_blamed() -> None:
    fit = identify([run(1, 0.008), run(2, 0.008)], method="gradient")
    assert not any("later after the command" in one for one in fit.warnings)
