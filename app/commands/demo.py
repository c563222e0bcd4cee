"""Watch the whole story: hide an effect, film it, track it, find it again."""

from __future__ import annotations

import argparse
from pathlib import Path

from servosight.app.arguments import add_seed
from servosight.app.output import console, progress


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight demo``."""
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, default=Path("out/demo"), help="out/demo"
    )
    add_seed(parser, default=1)


def run(args: argparse.Namespace) -> None:
    """Write recording/, model.toml, diagnosis.json and report.html."""
    from servosight.app.present import show_diagnosis
    from servosight.app.report import write_report
    from servosight.app.sources import track_folder
    from servosight.diagnose.diagnose import diagnose
    from servosight.models.atomic import write_text
    from servosight.models.json_io import json_text
    from servosight.models.recording_io import inspect_folder, load_recording
    from servosight.models.registry import catalogue
    from servosight.scenarios.produce import produce
    from servosight.scenarios.scenario import hidden

    out = console(args)
    place = args.output / "recording"
    scenario = hidden(args.seed)
    out.print(f"1. A servo with a hidden effect moves a fin and is filmed (seed {args.seed}).")
    with progress("filming") as show:
        produce(scenario, place, lambda done, total: show("frames", done, total))
    out.print("2. The camera measures the fin's angle.")
    track_folder(inspect_folder(place))
    recording = load_recording(place)
    out.print("3. The model is held against the measurement: what is missing?")
    with progress("diagnosing") as show:
        result = diagnose([recording], catalogue=catalogue(), auto=True, progress=show)
    values = result.to_json()
    result.actuator.save(args.output / "model.toml")
    write_text(args.output / "diagnosis.json", json_text(values))
    write_report(args.output / "report.html", result, [recording])
    show_diagnosis(out, values)
    out.print(f"4. What was hidden: {', '.join(scenario.effects)}.")
    out.print(f"5. Open {args.output / 'report.html'} in a browser.")
