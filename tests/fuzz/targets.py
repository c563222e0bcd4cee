"""Which files are damaged, how, and which commands read them."""

from __future__ import annotations

from dataclasses import dataclass

from fuzz.mutations import BYTES, SETTINGS, TABLE, TEXT, Mutation

MESSAGES = "--map command=goal.data:deg --map angle=angle.data:deg"
JOINTS = "--map command=action[1]:deg --map angle=state[1]:deg"


@dataclass(frozen=True)
class Target:
    """A file to damage, how, and the commands that read it; ``weight`` is how often."""

    file: str
    kinds: tuple[Mutation, ...]
    lines: tuple[str, ...]
    weight: int


TARGETS = (
    Target("log.csv", TABLE, ("compare model.toml log.csv", "import log.csv -o new"), 14),
    Target("log.csv", TABLE, ("identify log.csv --method gradient",), 3),
    Target("log.csv", TABLE, ("diagnose log.csv",), 1),
    Target("rec/recording.toml", SETTINGS, ("compare model.toml rec", "excite --analyse rec"), 12),
    Target("rec/command.csv", TABLE, ("compare model.toml rec", "excite --analyse rec"), 12),
    Target(
        "rec/command.csv",
        TABLE,
        ("bench run rec/command.csv -o new --servo maestro:none --camera none.mkv",),
        3,
    ),
    Target("rec/angle.csv", TABLE, ("compare model.toml rec", "excite --analyse rec"), 12),
    Target("rec/horn.csv", TABLE, ("compare model.toml rec", "excite --analyse rec"), 6),
    Target("rec/track.toml", SETTINGS, ("track rec", "compare model.toml rec"), 6),
    Target("command.csv", TABLE, ("excite --check command.csv --model model.toml",), 6),
    Target(
        "model.toml",
        SETTINGS,
        ("compare model.toml log.csv", "add model.toml dead_time log.csv"),
        8,
    ),
    Target(
        "model.toml",
        SETTINGS,
        (
            "export model.toml --to csv -o new.out",
            "export model.toml --to mjcf --on rec -o new.out",
        ),
        3,
    ),
    Target("model.fmu", BYTES, ("compare model.fmu log.csv --trust",), 1),
    Target("scenario.toml", SETTINGS, ("simulate scenario.toml -o new",), 6),
    Target("camera.toml", SETTINGS, ("track clip.mkv --camera camera.toml -o new.csv",), 6),
    Target("bam.json", TEXT, ("import bam.json -o new",), 8),
    Target("log.mat", BYTES, ("import log.mat -o new",), 1),
    Target("log.json", TEXT, ("import log.json -o new",), 4),
    Target("log.parquet", BYTES, ("import log.parquet -o new",), 1),
    Target("log.ulg", BYTES, (f"import log.ulg -o new {MESSAGES}",), 1),
    Target("log.mcap", BYTES, (f"import log.mcap -o new {MESSAGES}",), 1),
    Target("set/meta/info.json", TEXT, (f"import set -o new {JOINTS}",), 1),
    Target("set/data/a.parquet", BYTES, (f"import set -o new {JOINTS}",), 1),
    Target("clip.mkv", BYTES, ("track clip.mkv --pivot 32,24 -o new.csv",), 4),
    Target(
        "clip.mkv",
        BYTES,
        ("bench check --camera clip.mkv", "bench cameras --camera clip.mkv --exposure 0.001"),
        2,
    ),
    Target("film/frames.csv", TABLE, ("track film --pivot 32,24",), 1),
    Target("plugin.py", TEXT, ("effects --plugin plugin.py",), 8),
    # Read to its end, then refused, as the rows would replace a file.
    Target("sweep.toml", SETTINGS, ("sweep sweep.toml -o log.csv --workers 0",), 6),
    Target("swept/sweep.json", TEXT, ("results swept --json -",), 3),
    Target("answers.json", TEXT, ("advise --size 0.5 --results answers.json --json -",), 1),
    Target("swept/part-0.parquet", BYTES, ("results swept --json -",), 2),
)
