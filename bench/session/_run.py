"""A run: the servo plays a command, the camera films it, and both go onto one clock."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from servosight.bench.camera import VIDEO, Footage, OpenCamera, Recorder
from servosight.bench.safety import check_command, released
from servosight.bench.servo import CommandLog, StoredPlayback, SupervisedServo, play
from servosight.bench.session._lamp import CodedLamp
from servosight.bench.session._light import read_light
from servosight.bench.session._write import RUN_FILES, SIGN, Clocked, write_run
from servosight.bench.timing import LightPattern
from servosight.models.core import Array, InputError, check_folder, new_folder

REST_S = 0.6
"""Rest before and after a command: the camera's clock and the servo's standstill are seen there."""
_START_S = 10.0
_LATE_S = 30.0
_POLL_S = 0.02
_LEAST_SAMPLES = 20


class Light(Protocol):
    """A coded light in the picture (``bench.light``) that something else than the servo drives."""

    def begin(self) -> float:
        """Start the code; the host's time of its first bit, in s."""

    def end(self) -> float:
        """Switch the light off; the host's time, in s."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """What a run left: its folder, rows sent, frames, the light's clock; ``fault`` if it broke off.

    ``clock`` is None without a light in the picture; ``unlit`` says why, where one was driven.
    """

    folder: Path
    rows: int
    readings: int
    footage: Footage
    clock: Clocked | None
    fault: str | None = None
    unlit: str | None = None


def run(
    servo: SupervisedServo,
    camera: OpenCamera,
    time_s: Array,
    command_deg: Array,
    folder: Path,
    *,
    light: Light | None = None,
    source: str = "command.csv",
    force: bool = False,
) -> Run:
    """Play a command, (rows,) each, film it, and write the recording's folder.

    The command is held to the servo's limits before anything moves. Whatever ends the run, the
    servo goes to neutral and its torque off. Without ``light`` the servo's own one is switched,
    where its address names one. A lost link or a fault of the servo ends the run; what
    was recorded up to there, or up to a fault of the camera, is kept, and recording.toml says so
    (``ended``). An
    interruption leaves no folder. Raises InputError where nothing could be recorded.
    """
    check_command(servo.limits, time_s, command_deg, source)
    check_folder(folder, RUN_FILES, sign=SIGN, force=force)
    log = CommandLog()
    with new_folder(folder, RUN_FILES, sign=SIGN, force=force) as fresh:
        recorder = Recorder(camera, fresh)
        stage = _Stage(servo, recorder, light, log)
        fault = None
        try:
            with released(servo):
                stage.play(time_s, command_deg, source)
        except InputError as error:
            if not log.sent:
                raise
            fault = str(error)  # the recording up to here is kept
        finally:
            footage = stage.last_frame()
        fault = fault or footage.fault
        log.sigma_s = math.hypot(log.sigma_s, stage.sigma_s)
        found, unlit = None, None
        if stage.pattern is not None:
            try:
                found = Clocked(*read_light(fresh / VIDEO, footage, stage.pattern))
            except InputError as error:  # the recording is one without a light
                unlit = str(error)
        write_run(fresh, log, footage, found, servo.name, camera.name, fault, unlit)
    return Run(
        folder=folder,
        rows=len(log.sent),
        readings=len(log.readings),
        footage=footage,
        clock=found,
        fault=fault,
        unlit=unlit,
    )


class _Stage:
    """Servo, recorder and light during a run."""

    def __init__(
        self, servo: SupervisedServo, recorder: Recorder, light: Light | None, log: CommandLog
    ) -> None:
        self._servo, self._recorder, self._light, self._log = servo, recorder, light, log
        self._clock = servo.clock
        lamp = servo.driver.lamp if light is None else None
        self._lamp = None if lamp is None else CodedLamp(lamp, servo.clock)
        self.pattern: LightPattern | None = None
        self.sigma_s = 0.0 if lamp is None else lamp.sigma_s

    def play(self, time_s: Array, command_deg: Array, source: str) -> None:
        """Go to the first row, then film: no frame shows a motion that command.csv lacks."""
        clock = self._clock
        self._servo.move_to(float(command_deg[0]))
        self._rest()
        self._first_frame()
        begun_s = self._light.begin() if self._light is not None else None
        if self._lamp is not None:
            self._lamp.begin()
        try:
            self._rest()
            wait = None if self._lamp is None else self._lamp.wait
            play(self._servo, time_s, command_deg, self._log, source, wait)
            self._rest()
        finally:
            end_s = clock.now()
            self._recorder.stop_after(end_s)
            if begun_s is not None and self._light is not None:
                self.pattern = LightPattern.of_command(begun_s, self._light.end())
            elif self._lamp is not None:
                self.pattern = self._lamp.switched
                self._lamp.end()
                self.pattern = self._lamp.switched
            elif self._log.light_s is not None:
                self.pattern = self._of_board(self._log.light_s)

    def last_frame(self) -> Footage:
        """Wait for what the camera took up to the end of the run; it may come late."""
        clock, recorder = self._clock, self._recorder
        until = clock.now() + _LATE_S
        while recorder.ending and not recorder.ended.is_set() and clock.now() < until:
            clock.wait(clock.now() + _POLL_S)
        return recorder.finish()

    def _of_board(self, begun_s: float) -> LightPattern | None:
        """The light of a board that plays the command and the code by one clock of its own."""
        driver, sent = self._servo.driver, self._log.sent
        if not isinstance(driver, StoredPlayback) or len(sent) < _LEAST_SAMPLES:
            return None
        rate = (sent[-1][0] - sent[0][0]) / ((len(sent) - 1) * driver.period_s)
        return LightPattern.of_command(begun_s, sent[-1][0] + rate * driver.period_s, rate)

    def _rest(self) -> None:
        """Wait without moving."""
        until = self._clock.now() + REST_S
        while self._clock.now() < until:
            self._poll()

    def _poll(self) -> None:
        """Wait a little, and ask the servo: its watchdog would take a long silence for a fault."""
        self._servo.read()
        wait = self._clock.wait if self._lamp is None else self._lamp.wait
        wait(self._clock.now() + _POLL_S)

    def _first_frame(self) -> None:
        """Start the recorder; InputError where no frame comes."""
        clock, recorder = self._clock, self._recorder
        recorder.start()
        until = clock.now() + _START_S
        while not clock.wait_for(recorder.begun, clock.now() + _POLL_S) and clock.now() < until:
            self._servo.read()
        if recorder.fault is not None:
            raise InputError(recorder.fault)
        if not recorder.begun.is_set():
            raise InputError(f"no frame came within {_START_S:g} s; check the camera")


def run_words(run: Run) -> list[str]:
    """What a run left, a sentence each."""
    footage = run.footage
    lines = [
        f"{run.folder}: {run.rows} rows sent, {footage.number.size} frames, {footage.lost} lost, "
        f"{footage.rate_hz or 0.0:.3f} frames/s"
    ]
    if run.clock is None:
        lines += [run.unlit] if run.unlit is not None else []
        lines.append(
            "no coded light: the offset between command and video is not known, and dead time "
            "cannot be distinguished from the camera's latency"
        )
        return lines
    fit = run.clock.fit
    lines.append(
        f"clock: offset known to {1e3 * fit.offset_sigma_s:.2g} ms, drift {1e6 * fit.drift:+.1f} "
        f"ppm with a sigma of {1e6 * fit.drift_sigma:.2g} ppm, by the light at "
        f"{run.clock.light.place_px[0]:.0f},{run.clock.light.place_px[1]:.0f} px"
    )
    return lines
