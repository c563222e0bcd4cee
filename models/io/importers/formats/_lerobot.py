"""LeRobot data sets: a folder with meta/info.json and tables in Parquet below data/.

Source of the format: github.com/huggingface/lerobot, versions 2 and 3. A frame's ``timestamp`` is
its number over the rate, not the time at which anything was measured: the robot's state was read
somewhat before its action was sent, and nobody knows when. So dead time cannot be known.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import InputError, Recording, either, plain_name, read_settings
from servosight.models.io._power import power_columns
from servosight.models.io.importers._apart import Extract, Parser
from servosight.models.io.importers._apart import extract as extract_apart
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import Columns, chosen_columns, raw_columns
from servosight.models.io.importers._request import Column, Request
from servosight.models.io.importers.formats._parquet import number_columns, numbers, whole_columns
from servosight.models.io.tables import split_path

INFO = Path("meta") / "info.json"
PARSER = Parser(__name__, "a LeRobot data set", "pyarrow")
_LARGEST_INFO = 1 << 24
NOMINAL = (
    "the time stamps are nominal, frame over rate, so that no dead time can be found from them: "
    "it is the servo's and that of the program which wrote the data set"
)


def recognises(path: Path, start: bytes) -> bool:
    """A folder with the file that describes a data set."""
    return (path / INFO).is_file()


def read_lerobot(path: Path, request: Request) -> Recording:
    """Read one episode (``request.part``); ``action[2]`` or ``action[elbow_flex]`` is one joint."""
    columns = {"time": Column("timestamp", "s"), **request.columns}
    request = replace(request, columns=columns)
    info = _info(path)
    names = _names(info)
    place = str(path / INFO)
    table = Columns(place, list(names), lambda name: np.empty(0), range, "frame", split=split_path)
    chosen = {column.name for column in chosen_columns(path, table, request).values()}
    wanted = sorted({names[name] for name in (*chosen, *power_columns(list(names)))})
    found = extract_apart(path, PARSER, wanted, episode=request.part)
    episodes = int(found.facts["episodes"])
    if not found.columns or not found.columns[wanted[0]].size:
        raise InputError(
            f"{path}: has no episode {request.part}, expected one of its {episodes}; choose it "
            f"by {either('part', '--part')}, from 0"
        )
    table = replace(table, numbers=lambda name: found.columns[names[name]])
    raw, more = raw_columns(path, table, request)
    rate = info.get("fps")
    source = {
        "name": plain_name(path.name),
        "format": "lerobot",
        "episode": request.part,
        **({"fps": rate} if isinstance(rate, int | float) else {}),
        **{f"{quantity}_column": one.column for quantity, one in raw.items()},
    }
    notes = [f"{path}: episode {request.part} of {episodes}; {NOMINAL}", *more]
    details = {"source": source, "clock_note": NOMINAL}
    recording = assemble(path, raw, request, details, notes, "sensor")
    return replace(recording, offset_sigma_s=math.inf)


def extract(path: Path, wanted: Sequence[str], episode: int = 0) -> Extract:
    """The wanted columns of one episode; runs in a process of its own."""
    import pyarrow.parquet as pq

    parts: dict[str, list[Any]] = {name: [] for name in wanted}
    seen: set[int] = set()
    names: tuple[str, ...] = ()
    for file in sorted((path / "data").rglob("*.parquet")):
        table = pq.ParquetFile(str(file))
        which = np.asarray(table.read(columns=["episode_index"]).column(0).to_numpy())
        seen.update(np.unique(which).tolist())
        if not np.any(which == episode):
            continue
        names = names or number_columns(table.schema_arrow, lambda name: ())
        own = table.read(columns=whole_columns(wanted, table.schema_arrow.names))
        for name in wanted:
            parts[name].append(numbers(own, name)[which == episode])
    found = {name: np.concatenate(part) for name, part in parts.items() if part}
    return Extract(found, names, facts={"episodes": len(seen)})


def _info(path: Path) -> dict[str, Any]:
    kind = "meta/info.json of a LeRobot data set"
    info = read_settings(path / INFO, kind, form="JSON", largest=_LARGEST_INFO)
    if not isinstance(info.get("features"), Mapping):
        raise InputError(
            f"{path / INFO}: key features is missing, expected the description of each column, as "
            f"LeRobot writes it since version 2; convert the data set"
        )
    return info


def _names(info: Mapping[str, Any]) -> dict[str, str]:
    """The names of all numbers, and the columns, or places in columns of lists, that they are."""
    found: dict[str, str] = {}
    for name, feature in info["features"].items():
        shape = feature.get("shape") if isinstance(feature, Mapping) else None
        kind = str(feature.get("dtype")) if isinstance(feature, Mapping) else ""
        if not kind.startswith(("float", "int", "bool")) or not isinstance(shape, list):
            continue
        if len(shape) != 1 or not isinstance(shape[0], int) or not 0 < shape[0] <= 1000:
            continue
        if shape[0] == 1:
            found[name] = name
            continue
        labels = feature.get("names")
        if isinstance(labels, Mapping):  # {"motors": [...]}
            labels = next(iter(labels.values()), None)
        for place in range(shape[0]):
            found[f"{name}[{place}]"] = f"{name}[{place}]"
            if isinstance(labels, list) and place < len(labels):
                found[f"{name}[{labels[place]}]"] = f"{name}[{place}]"
    return found
