"""What an export says of itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from servosight.models.core import Result, Table


@dataclass(frozen=True)
class OmittedEffect:
    """An effect that the target lacks, or has in a simpler form (``approximation``).

    ``without_deg`` is the rms change of the model's angle on the trial when the effect is left out.
    """

    effect: str
    approximation: str | None
    without_deg: float


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class ExportResult(Result):
    """An exported model, run in its target and compared with the model.

    ``kind`` is the word behind ``--to``, ``file`` what was written. ``target`` is the program that
    it was run in, or would have been: ``not_run`` then says why not. ``trial`` is what it was
    run on, of ``samples``. ``difference_rms_deg`` and ``difference_max_deg`` are between target and
    model. On a recording, ``model_rmse_deg`` and ``target_rmse_deg`` are their errors against the
    measured angle. ``omissions`` are the effects that the target cannot express.

    >>> import servosight as ss
    >>> fit = ss.identify(ss.simulate(seed=3), method="gradient")
    >>> result = ss.export(fit, "header", "servo.h")
    >>> result.kind, result.file, len(result.omissions)
    ('header', 'servo.h', 0)
    """

    TYPE: ClassVar[str] = "export"

    kind: str
    file: str
    target: str
    trial: str
    samples: int
    difference_rms_deg: float | None
    difference_max_deg: float | None
    model_rmse_deg: float | None
    target_rmse_deg: float | None
    not_run: str | None
    omissions: Table[OmittedEffect]
    notes: tuple[str, ...]
