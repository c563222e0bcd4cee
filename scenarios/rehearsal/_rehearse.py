"""One rehearsed run, as the commands of the bench would do it with real devices."""

from __future__ import annotations

from pathlib import Path

import tomli_w

from servosight.bench.camera import Given
from servosight.bench.safety import Limits
from servosight.bench.servo import open_servo
from servosight.bench.session import RUN_FILES, check_servo, run, run_words
from servosight.models.core import InputError, write_text
from servosight.models.excitation import standard
from servosight.scenarios.rehearsal._bench import Rehearsal, virtual_bench

TRUTH = "truth.toml"
AMPLITUDE_DEG = 20.0
ROWS_HZ = 50.0


def rehearse(
    rehearsal: Rehearsal, folder: Path, duration_s: float, *, force: bool = False
) -> list[str]:
    """Check the virtual servo, run the standard command, write the recording; what happened."""
    command = standard(duration_s, AMPLITUDE_DEG, rehearsal.seed, ROWS_HZ)
    _drop_truth(folder)
    with virtual_bench(rehearsal) as bench:
        given = Given(exposure_s=rehearsal.camera.exposure_s, meaning="exposure_start")
        servo = open_servo(bench.servo, Limits(low_deg=-30.0, high_deg=30.0), bench.clock)
        camera = bench.open_camera(given)
        lines = [f"{line.what}: {line.words}" for line in check_servo(servo)]
        try:
            done = run(
                servo,
                camera,
                command.time_s,
                command.command_deg,
                folder,
                light=bench.light,
                force=force,
            )
        finally:
            camera.close()
            servo.close()
    if done.fault is not None:
        raise InputError(f"{folder}: the rehearsal broke off: {done.fault}")
    return [*lines, *run_words(done)]


def write_truth(rehearsal: Rehearsal, folder: Path) -> None:
    """Write what was hidden beside the recording, for whoever scores it."""
    write_text(folder / TRUTH, tomli_w.dumps(rehearsal.truth()))


def _drop_truth(folder: Path) -> None:
    """Remove the truth of an earlier rehearsal in a folder of the bench's own."""
    names = {entry.name for entry in folder.iterdir()} if folder.is_dir() else set()
    if "bench.toml" in names and names <= {*RUN_FILES, "angle.csv", TRUTH}:
        (folder / TRUTH).unlink(missing_ok=True)
