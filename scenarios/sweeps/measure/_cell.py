"""One cell: from its settings to the columns of its row.

What it works with is imported when it runs: the process that hands out cells has no need of it.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.sweeps.plan import (
    Cell,
    Sweep,
    hidden_names,
    scenario_of,
    user_function,
    versions,
)

Row = dict[str, Any]


@dataclass(frozen=True)
class CellWork:
    """What all cells of a sweep have in common, sent to the workers with each batch."""

    base: Mapping[str, Any]
    do: tuple[str, ...]
    model: str
    video: bool
    source: str

    @classmethod
    def of(cls, sweep: Sweep) -> CellWork:
        """The part of a sweep that its cells need."""
        return cls(sweep.base, sweep.do, sweep.model, sweep.video, sweep.source)

    def __call__(self, cell: Cell) -> Row:
        """The columns of a cell's row that are not known before it has run."""
        return measure(self, cell)


def measure(work: CellWork, cell: Cell) -> Row:
    """Make the cell's recording, do with it what the sweep says, and score it.

    Raises whatever the scenario, the tracker, the fit or the user's function raises.
    """
    scenario = scenario_of(
        work.base,
        cell.settings,
        cell.scenario_seed,
        cell.draw_seed,
        video=work.video,
        source=work.source,
    )
    row: Row = {"scenario_seed": cell.scenario_seed}
    began = time.perf_counter()
    recording, times = _recorded(scenario, began)
    row |= {"samples": recording.time_s.size}
    if "identify" in work.do:
        row |= _identify(recording, scenario, work.model, times)
    if "diagnose" in work.do:
        row |= _diagnose(recording, scenario, times, scored="identify" in work.do)
    for name in work.do:
        if name not in ("identify", "diagnose"):
            began = time.perf_counter()
            row |= user_function(name, work.source)(recording, scenario)
            times[f"{name}_s"] = time.perf_counter() - began
    return {**row, "versions": versions(video=work.video), **times}


def _recorded(scenario: Scenario, began: float) -> tuple[Recording, Row]:
    """The recording, and how long it took to make [s]."""
    from servosight.scenarios.produce import produce, simulated

    if not scenario.video:
        recording: Recording = simulated(scenario)
        return recording, {"simulate_s": time.perf_counter() - began}
    from servosight.sources import read

    with tempfile.TemporaryDirectory(prefix="servosight-cell-") as folder:
        place = Path(folder) / "recording"
        produce(scenario, place)
        filmed = time.perf_counter()
        recording = read(place)
    return recording, {"simulate_s": filmed - began, "track_s": time.perf_counter() - filmed}


def _identify(recording: Recording, scenario: Scenario, model: str, times: Row) -> Row:
    from servosight.identify.fit import identify
    from servosight.scenarios.sweeps.measure._scores import bounds, errors

    began = time.perf_counter()
    known = catalogue()
    true_effects = [name for name in hidden_names(scenario) if name in known]
    fit = identify(recording, true_effects if model == "hidden" else ())
    times["identify_s"] = time.perf_counter() - began
    truth = scenario.truth()
    noise = fit.noise_deg if scenario.video else scenario.noise_deg
    return {
        **errors(fit.parameters, truth),
        **bounds(recording, truth, true_effects, noise),
        "rmse_deg": fit.rmse_deg,
        "noise_deg": noise,
        "noise_found_deg": fit.noise_deg,
    }


def _diagnose(recording: Recording, scenario: Scenario, times: Row, *, scored: bool) -> Row:
    from servosight.diagnose import diagnose
    from servosight.scenarios.sweeps.measure._scores import errors

    began = time.perf_counter()
    found = diagnose([recording], catalogue=catalogue(), auto=True)
    times["diagnose_s"] = time.perf_counter() - began
    last = found.ladder[-1]
    row: Row = {}
    if not scored:
        row = {**errors(last.parameters, scenario.truth()), "rmse_deg": last.train_rmse_deg}
    return {
        **row,
        "verdict": found.verdict.value,
        "effects": list(found.effects),
        "named": set(found.effects) == set(hidden_names(scenario)),
        "noise_deg": found.noise_deg if scenario.video else scenario.noise_deg,
        "noise_found_deg": found.noise_deg,
        "floor_deg": found.floor_deg,
        "held_out_rmse_deg": last.held_out_rmse_deg,
    }
