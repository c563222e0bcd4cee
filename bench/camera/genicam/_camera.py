"""Industrial cameras by GenICam, through harvesters and the GenTL producer of the camera's maker.

A stamp counts ticks of the camera's own clock. The latch of that clock, read between two times of
the host, turns stamps into the host's time, to half the time that this takes. What a stamp means is
the maker's choice: usually the start of exposure, for which it is taken.
"""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from servosight.bench.camera._found import FoundCamera
from servosight.bench.camera._protocol import (
    CameraLost,
    CapturedFrame,
    Given,
    Now,
    Stream,
    check_size,
)
from servosight.bench.camera._settings import read_settings
from servosight.bench.camera.genicam._features import Features, GenicamSettings, fault_words
from servosight.models.core import InputError

PRODUCERS = "GENICAM_GENTL64_PATH"
"""Folders with GenTL producers (GenTL Standard, section 2.3): what the makers' programs set."""
_EARLY_S = 0.002  # a picture cannot arrive before it is taken, but for the latch's uncertainty
_LAST_ID, _NEAR_LAST = 65535, 65000  # GigE Vision 1 counts from 1 to 65535, then again


class GenicamCamera:
    """An open camera of GenICam, grey pictures of 8 bits."""

    def __init__(
        self,
        address: str,
        settings: GenicamSettings,
        given: Given,
        now: Now,
        harvester: Any,
        faults: tuple[type[Exception], ...],
    ) -> None:
        self.name = address
        self._given, self._now, self._faults = given, now, faults
        self._harvester, self._acquirer = harvester, None
        try:
            self._acquirer = self._found(settings)
            nodes = self._acquirer.remote_device.node_map
            self._features = Features(address, nodes, now, faults)
            self._offset_s: float | None = None
            controls = self._features.fix(settings)
            with_stamp, size = self._first_picture()
        except BaseException:
            self.close()
            raise
        known = dict(controls)
        self.stream = given.over(
            Stream(
                size=size,
                coding="gray",
                meaning="exposure_start" if with_stamp else "arrival",
                rate_hz=known.get("rate"),
                exposure_s=known.get("exposure"),
                settings=controls,
                host_clock=self._offset_s is not None,
            )
        )

    def frames(self) -> Generator[CapturedFrame]:
        """Frames from now on; closing the generator stops the stream."""
        acquirer: Any = self._acquirer
        try:
            acquirer.start()
            last: int | None = None
            number = -1
            while True:
                one = self._next(acquirer)
                with one as buffer:
                    arrival_s = self._now()
                    reported = self._features.optional(buffer, "module", "frame_id")
                    number += _step(last, reported)
                    last = reported
                    stamp_s = self._features.stamp_s(buffer)
                    data = _gray(buffer.payload.components[0], self.name)
                if stamp_s is None:
                    stamp_s = arrival_s
                else:
                    stamp_s += self._offset_s or 0.0
                yield CapturedFrame(
                    number=number, stamp_s=stamp_s, arrival_s=arrival_s, data=data.tobytes()
                )
        except self._faults as error:
            raise CameraLost(
                f"{self.name}: the camera is gone ({fault_words(error)}); check its cable and power"
            ) from None
        finally:
            with suppress(*self._faults):
                acquirer.stop()

    def close(self) -> None:
        """Let go of the camera and of its producer."""
        acquirer, self._acquirer = self._acquirer, None
        harvester, self._harvester = self._harvester, None
        with suppress(*self._faults):
            if acquirer is not None:
                acquirer.destroy()
        with suppress(*self._faults):
            if harvester is not None:
                harvester.reset()

    def _found(self, settings: GenicamSettings) -> Any:
        """The camera of that serial number, or the only one."""
        self._harvester.update()
        serials = [
            str(one.property_dict["serial_number"]) for one in self._harvester.device_info_list
        ]
        wanted = settings.serial
        if not serials or (wanted is not None and wanted not in serials):
            there = f"there are {', '.join(serials)}" if serials else "the producer finds none"
            raise InputError(
                f"{self.name}: no camera{f' {wanted}' if wanted else ''} ({there}); check cable, "
                f"power and serial number, and that the producer is the camera maker's"
            )
        if wanted is None and len(serials) > 1:
            raise InputError(
                f"{self.name}: there are {len(serials)} cameras, expected the serial number of "
                f"one; add serial=NUMBER with one of {', '.join(serials)}"
            )
        try:
            return self._harvester.create(serials.index(wanted) if wanted is not None else 0)
        except self._faults as error:
            raise InputError(
                f"{self.name}: cannot be opened ({fault_words(error)}); end other "
                f"programs that use it"
            ) from None

    def _first_picture(self) -> tuple[bool, tuple[int, int]]:
        """Look at one picture: whether it has a stamp, and its size; put the clocks together."""
        acquirer: Any = self._acquirer
        try:
            offset_s = self._features.clock_offset_s()
            acquirer.start()
            with self._next(acquirer) as buffer:
                arrival_s, device_s = self._now(), self._features.stamp_s(buffer)
                height, width = _gray(buffer.payload.components[0], self.name).shape
        except self._faults as error:
            raise CameraLost(
                f"{self.name}: delivers no picture ({fault_words(error)}); check its cable "
                f"and power"
            ) from None
        finally:
            with suppress(*self._faults):
                acquirer.stop()
        check_size(self.name, (width, height))
        if device_s is not None and offset_s is not None:
            late_s = arrival_s - device_s - offset_s
            if -_EARLY_S <= late_s <= self._given.timeout_s:
                self._offset_s = offset_s
        return device_s is not None, (width, height)

    def _next(self, acquirer: Any) -> Any:
        """The next whole picture; one that is damaged or incomplete is a lost frame."""
        until_s = self._now() + self._given.timeout_s
        while (left_s := until_s - self._now()) > 0.0:
            buffer = acquirer.try_fetch(timeout=left_s)
            if buffer is not None:
                return buffer
        raise CameraLost(
            f"{self.name}: no whole picture came within {self._given.timeout_s:g} s; check the "
            f"camera, its cable and the network's packet size"
        )


def _step(last: int | None, reported: int | None) -> int:
    """By how much a frame's number grows; a number that falls begins to count anew."""
    if last is None or reported is None:
        return 1
    if reported > last:
        return reported - last
    return (
        reported - last + _LAST_ID if last >= _NEAR_LAST and reported < _LAST_ID - _NEAR_LAST else 1
    )


def _gray(component: Any, name: str) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """A picture of 8 bits a pixel, (height, width), copied out of the producer's memory."""
    width, height = int(component.width), int(component.height)
    data = np.asarray(component.data)
    if component.data_format != "Mono8" or height == 0 or data.size < width * height:
        raise CameraLost(
            f"{name}: sends {component.data_format} of {width} x {height} px, expected Mono8; end "
            f"what changes the camera's mode"
        )
    lines = data[: data.size // height * height].reshape(height, -1)  # padded at their ends
    return np.array(lines[:, :width], dtype=np.uint8)


def list_genicam() -> Iterator[FoundCamera]:
    """Each camera of the producers of ``GENICAM_GENTL64_PATH``; none without them."""
    for file in _producers(""):
        try:
            harvester, faults = _harvester("genicam:", [file])
        except InputError:  # not installed, as with most who have no such camera
            return
        with suppress(*faults):
            harvester.update()
            for one in harvester.device_info_list:
                reported = one.property_dict
                yield FoundCamera(
                    device=f"genicam:{file}?serial={reported['serial_number']}",
                    name=str(reported["display_name"]),
                )
        with suppress(*faults):
            harvester.reset()


def open_genicam(address: str, given: Given, now: Now) -> GenicamCamera:
    """Open ``genicam:/opt/maker/producer.cti?serial=40012345&rate=120&exposure=0.002``.

    Without a path, ``genicam:?serial=40012345``, the producers of ``GENICAM_GENTL64_PATH`` are
    asked.
    """
    settings = read_settings(address, GenicamSettings, texts=("serial",))
    files = _producers(address.removeprefix("genicam:").partition("?")[0])
    if not files:
        raise InputError(
            f"{address}: no GenTL producer there; expected the .cti file of the camera's maker, "
            f"install the maker's program or set {PRODUCERS} to its folder"
        )
    harvester, faults = _harvester(address, files)
    return GenicamCamera(address, settings, given, now, harvester, faults)


def _producers(path: str) -> list[str]:
    """The GenTL producer at ``path``, or all in the folders of ``GENICAM_GENTL64_PATH``."""
    if path:
        return [path] if Path(path).is_file() else []
    folders = [one for one in os.environ.get(PRODUCERS, "").split(os.pathsep) if one]
    return [str(file) for folder in folders for file in sorted(Path(folder).glob("*.cti"))]


def _harvester(address: str, files: list[str]) -> tuple[Any, tuple[type[Exception], ...]]:
    """A Harvester with these producers, and what the library raises."""
    try:
        from genicam import genapi, gentl
        from harvesters.core import Harvester
    except ModuleNotFoundError:
        raise InputError(
            f"{address}: the package harvesters is not installed, expected it for cameras of "
            f"GenICam; run pip install 'servosight[genicam]'"
        ) from None
    except ImportError as error:  # Debian's Python comes without libpython3.11.so, say
        raise InputError(
            f"{address}: the package harvesters cannot be loaded ({error}), expected it for "
            f"cameras of GenICam; install the library that it lacks"
        ) from None
    harvester = Harvester()
    for file in files:
        harvester.add_file(file)
    return harvester, (genapi.GenericException, gentl.GenericException)
