"""Which camera shows an effect of a size: the answers of a sweep, held against that size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from servosight.models.core import InputError, Table, did_you_mean, read_typed
from servosight.scenarios.sweeps.answers._detection import share_at
from servosight.scenarios.sweeps.answers._found import Found
from servosight.scenarios.sweeps.answers._summary import Summary

SHIPPED = Path(__file__).parents[1] / "ready" / "camera_for_backlash.json"
"""The summary of a ready sweep, as ``servosight results --json`` writes it."""


@dataclass(frozen=True, kw_only=True)
class Advice:
    """One setting's answer: the ``share`` of recordings in which the size is found.

    ``enough`` is "yes" where the whole interval of the smallest size lies below, "no" where it
    lies above, and "perhaps" where the sweep is too small to tell.
    """

    settings: Mapping[str, Any]
    enough: str
    share: float | None
    smallest: float | None
    low: float | None
    high: float | None
    sentence: str


def advise(found: Sequence[Found], effect: str, size: float) -> Table[Advice]:
    """Whether each setting of a sweep shows ``effect`` of ``size``, the best first.

    Raises InputError where the sweep did not look for that effect.
    """
    known = list(dict.fromkeys(one.effect for one in found))
    if effect not in known:
        raise InputError(
            f"--effect {effect}: this sweep did not look for it, expected one of "
            f"{', '.join(known) or 'its effects, and it has none'}{did_you_mean(effect, known)}; "
            f"run a sweep with the axis effects.{effect}.PARAMETER and name it with --results"
        )
    answers = [_held_against(one, size) for one in found if one.effect == effect]
    order = {"yes": 0, "perhaps": 1, "no": 2}
    return Table(sorted(answers, key=lambda one: (order[one.enough], one.smallest or 1e300)))


def saved_answers(path: Path) -> Summary:
    """A summary from its JSON; InputError where it is none."""
    try:
        return read_typed(path, Summary)
    except InputError as error:
        raise InputError(
            f"{error}; expected what `servosight results --json` writes, or a sweep's folder"
        ) from None


def _held_against(one: Found, size: float) -> Advice:
    counts = one.detection
    enough = "perhaps"
    if counts.size is None or (counts.low is not None and size < counts.low):
        enough = "no" if size <= max(counts.sizes) else "perhaps"
    elif counts.high is not None and size >= counts.high:
        enough = "yes"
    return Advice(
        settings=one.settings,
        enough=enough,
        share=share_at(size, counts),
        smallest=counts.size,
        low=counts.low,
        high=counts.high,
        sentence=one.sentence,
    )
