"""``ss.bench``: the bench from Python, as ``servosight bench`` does it.

Devices are given by their addresses, as on the command line (docs/bench.md). Nothing moves without
``arm=True``.

>>> import servosight as ss
>>> isinstance(ss.bench.cameras(), list)
True
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from servosight.scenarios.durations import EXPERIMENT_S, REHEARSAL_S, check_duration

if TYPE_CHECKING:
    from servosight.bench.camera import FoundCamera, Given
    from servosight.bench.safety import Limits
    from servosight.bench.session import Line, Run
    from servosight.models.core import Recording
    from servosight.models.excitation import Excitation
    from servosight.scenarios.bench_experiment import BenchExperiment

__all__ = ["auto", "cameras", "check", "rehearse", "run"]


def cameras() -> list[FoundCamera]:
    """Each mode of each camera of this computer; printed, a line of ``bench cameras``.

    >>> import servosight as ss
    >>> all(":" in one.address for one in ss.bench.cameras())
    True
    """
    from servosight.bench.camera import list_cameras

    return list_cameras()


def check(
    *,
    camera: str | None = None,
    servo: str | None = None,
    arm: bool = False,
    limits: Limits | None = None,
    given: Given | None = None,
) -> list[Line]:
    """Check a camera and a servo by their addresses. Lines with ``good`` and words.

    Nothing moves without ``arm=True``; with it, where all else is in order, the servo turns by 5
    deg to show the surface to the camera.

    ``given`` is what is stated of the camera, such as ``Given(exposure_s=0.004)``.

    >>> import servosight as ss
    >>> ss.bench.check()
    []
    """
    from contextlib import ExitStack, closing

    from servosight.bench.camera import open_camera
    from servosight.bench.servo import open_servo
    from servosight.bench.session import check_camera, check_servo, check_surface

    lines: list[Line] = []
    looking = asked = None
    with ExitStack() as stack:
        if camera is not None:
            looking = stack.enter_context(closing(open_camera(camera, given)))
            lines += check_camera(looking)
        if servo is not None:
            asked = stack.enter_context(closing(open_servo(servo, limits)))
            lines += check_servo(asked)
        if arm and looking is not None and asked is not None and all(one.good for one in lines):
            lines += check_surface(asked, looking)
    return lines


def run(
    command: Excitation | Path | str,
    folder: Path | str,
    *,
    servo: str,
    camera: str,
    arm: bool = False,
    limits: Limits | None = None,
    given: Given | None = None,
    force: bool = False,
) -> Run:
    """Play a command on a servo, film it, and write the recording's folder.

    ``command`` is a CSV file, or an ``Excitation``. Raises InputError without ``arm=True``.

    >>> import servosight as ss
    >>> ss.bench.run("command.csv", "rec", servo="maestro:/dev/none", camera="none.mkv")
    Traceback (most recent call last):
    servosight.models.base._errors.InputError: ss.bench.run: moves the servo; clear its way, and \
say so with arm=True
    """
    from contextlib import closing

    from servosight.bench.camera import open_camera
    from servosight.bench.servo import open_servo
    from servosight.bench.session import run as record
    from servosight.models.excitation import Excitation

    _check_armed("run", arm)
    source = "command" if isinstance(command, Excitation) else str(command)
    rows = command if isinstance(command, Excitation) else Excitation.load(Path(command))
    with closing(open_camera(camera, given)) as film, closing(open_servo(servo, limits)) as driven:
        return record(
            driven, film, rows.time_s, rows.command_deg, Path(folder), source=source, force=force
        )


def auto(
    folder: Path | str,
    *,
    servo: str,
    camera: str,
    arm: bool = False,
    duration_s: float = EXPERIMENT_S,
    seed: int = 0,
    limits: Limits | None = None,
    given: Given | None = None,
    ask: Callable[[str], bool] = lambda question: False,
    force: bool = False,
) -> BenchExperiment:
    """Zero, run, track and diagnose; ``ask`` decides on each further experiment that is proposed.

    The command lasts ``duration_s``, 4 to 120 s.

    >>> import servosight as ss
    >>> ss.bench.auto("out", servo="maestro:/dev/none", camera="none.mkv")
    Traceback (most recent call last):
    servosight.models.base._errors.InputError: ss.bench.auto: moves the servo; clear its way, and \
say so with arm=True
    """
    from contextlib import closing

    from servosight.bench.camera import open_camera
    from servosight.bench.servo import open_servo
    from servosight.scenarios.bench_experiment import carry_out

    _check_armed("auto", arm)
    check_duration(duration_s)
    with closing(open_camera(camera, given)) as film, closing(open_servo(servo, limits)) as driven:
        return carry_out(
            driven, film, Path(folder), duration_s=duration_s, seed=seed, ask=ask, force=force
        )


def rehearse(
    folder: Path | str,
    *,
    seed: int = 1,
    kind: Literal["board", "dynamixel", "feetech", "maestro"] = "dynamixel",
    duration_s: float = REHEARSAL_S,
    force: bool = False,
) -> tuple[Recording, dict[str, Any]]:
    """A recording of a virtual servo before a virtual camera on the wire, and what is hidden.

    The command lasts ``duration_s``, 4 to 120 s.

    >>> import servosight as ss
    >>> from servosight.scenarios.rehearsal import Rehearsal
    >>> list(Rehearsal.drawn(2).effects)
    ['asymmetric_gain']
    """
    from servosight.scenarios.rehearsal import Rehearsal
    from servosight.scenarios.rehearsal import rehearse as record
    from servosight.sources import read

    check_duration(duration_s)
    drawn = Rehearsal.drawn(seed, kind)
    record(drawn, Path(folder), duration_s, force=force)
    return read(Path(folder)), drawn.truth()


def _check_armed(verb: str, arm: bool) -> None:
    from servosight.models.core import InputError

    if not arm:
        raise InputError(
            f"ss.bench.{verb}: moves the servo; clear its way, and say so with arm=True"
        )
