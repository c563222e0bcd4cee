"""An FMU as a model: opened in a process of its own, with limits on time and memory."""

from __future__ import annotations

import math
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np

from servosight.models.core import Array, InputError
from servosight.models.fmu import host
from servosight.models.fmu._archive import unpacked
from servosight.models.fmu._wire import Broken, packed, received

_PROGRAM = f"import sys; from {host.__name__} import main; sys.exit(main({{memory}}))"


@dataclass(frozen=True, kw_only=True)
class FmuLimits:
    """What the process of an FMU may take: address space, time to open it, time for one run."""

    memory_bytes: int = 4 << 30
    open_s: float = 60.0
    run_s: float = 120.0


@dataclass(frozen=True, kw_only=True)
class FmuVariable:
    """A number of an FMU; ``low`` and ``high`` may be infinite, ``start`` None."""

    name: str
    causality: str
    variability: str
    start: float | None
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class Fmu:
    """An open FMU; see :func:`open_fmu`. ``step_s`` is the one step that it takes, else None."""

    path: Path
    version: str
    name: str
    interfaces: tuple[str, ...]
    variables: tuple[FmuVariable, ...]
    step_s: float | None
    process: _Process = field(repr=False)

    def of(self, causality: str) -> tuple[FmuVariable, ...]:
        """Its inputs, outputs or parameters."""
        return tuple(one for one in self.variables if one.causality == causality)

    def run(
        self,
        time_s: Array,
        command: Array,
        *,
        command_name: str,
        output_name: str,
        start: Mapping[str, float] | None = None,
    ) -> Array:
        """The output at ``time_s`` (steps + 1,) under a ``command`` (steps,) held between them.

        Raises InputError where the run fails.
        """
        names = list(start or {})
        row = np.array([[float(value) for value in (start or {}).values()]])
        (angle,), (error,) = self.run_rows(time_s, command, names, row, command_name, output_name)
        if error:
            raise InputError(
                f"{self.path}: does not run on this command ({error}), expected an FMU that does; "
                f"try it in the tool it is of"
            )
        return angle

    def run_rows(
        self,
        time_s: Array,
        command: Array,
        names: Sequence[str],
        rows: Array,
        command_name: str,
        output_name: str,
    ) -> tuple[list[Array], list[str]]:
        """Runs for ``rows`` (runs, names) of parameters: outputs, NaN for a failed one, why."""
        table = {
            "names": list(names), "runs": len(rows), "input": command_name, "output": output_name,
        }  # fmt: skip
        answer, arrays = self.process.ask(packed(table, [time_s, command, rows.ravel()]), len(rows))
        errors = answer.get("errors")
        if not isinstance(errors, list) or not len(errors) == len(arrays) == len(rows):
            raise self.process.broken()
        if any(one.shape != time_s.shape for one in arrays):
            raise self.process.broken()
        return arrays, [str(one) for one in errors]


@contextmanager
def open_fmu(
    path: Path, *, interface: str | None = None, limits: FmuLimits | None = None
) -> Iterator[Fmu]:
    """Check the archive, unpack it, load it in another process; InputError says what is wrong.

    Its native code runs from here on with the user's rights, in a process of its own.
    """
    limits = limits or FmuLimits()
    with unpacked(path) as folder:
        process = _Process(path, folder, limits)
        try:
            opening = {"folder": str(folder), "interface": interface}
            table, _ = process.ask(packed({"open": opening}), limit_s=limits.open_s)
            yield _fmu(path, table, process)
        finally:
            process.close()


class _Process:
    """The process, and what to say of its end."""

    def __init__(self, path: Path, folder: Path, limits: FmuLimits) -> None:
        self.path, self.limits = path, limits
        self.child = subprocess.Popen(
            [sys.executable, "-P", "-c", _PROGRAM.format(memory=limits.memory_bytes)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            start_new_session=True,
        )

    def ask(
        self, message: bytes, runs: int = 1, limit_s: float | None = None
    ) -> tuple[dict[str, Any], list[Array]]:
        """Send a message and wait for the answer; InputError where none comes in time."""
        limit_s = self.limits.run_s * max(runs, 1) if limit_s is None else limit_s
        until = time.monotonic() + limit_s
        assert self.child.stdin is not None
        assert self.child.stdout is not None
        answers = self.child.stdout
        try:
            self._write(self.child.stdin, message, until)
            table, arrays = received(lambda count: self._read(answers, count, until))
        except (BrokenPipeError, EOFError):
            raise self._refused(self._end()) from None
        except TimeoutError:
            raise self._refused(f"it takes more than {limit_s:g} s") from None
        except Broken:
            raise self.broken() from None
        if "error" in table:
            raise self._refused(str(table["error"])[:300])
        return table, arrays

    def broken(self) -> InputError:
        """What to raise where an answer makes no sense."""
        return self._refused("its answer is no such thing as was asked for")

    def close(self) -> None:
        """End the process and all that it started."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.child.pid, signal.SIGKILL)
        for stream in (self.child.stdin, self.child.stdout):
            if stream is not None:
                with suppress(BrokenPipeError):
                    stream.close()
        self.child.wait()

    def _write(self, stream: IO[bytes], message: bytes, until: float) -> None:
        os.set_blocking(stream.fileno(), False)
        rest = memoryview(message)
        with selectors.DefaultSelector() as ready:
            ready.register(stream, selectors.EVENT_WRITE)
            while rest:
                left = until - time.monotonic()
                if left <= 0.0 or not ready.select(left):
                    raise TimeoutError
                rest = rest[os.write(stream.fileno(), rest[: 1 << 20]) :]

    def _read(self, stream: IO[bytes], count: int, until: float) -> bytes:
        found = bytearray()
        with selectors.DefaultSelector() as ready:
            ready.register(stream, selectors.EVENT_READ)
            while len(found) < count:
                left = until - time.monotonic()
                if left <= 0.0 or not ready.select(left):
                    raise TimeoutError
                part = os.read(stream.fileno(), min(count - len(found), 1 << 20))
                if not part:
                    raise EOFError
                found += part
        return bytes(found)

    def _end(self) -> str:
        try:
            code = self.child.wait(5.0)
        except subprocess.TimeoutExpired:
            return "its process closed its answers"
        if code < 0:
            return f"its process was ended by {signal.Signals(-code).name}"
        return f"its process ended by itself with exit code {code}"

    def _refused(self, why: str) -> InputError:
        return InputError(
            f"{self.path}: cannot be used as an FMU ({why}), expected one that loads and runs on "
            f"this machine; export it again for this platform, or try it in the tool it is of"
        )


def _fmu(path: Path, table: dict[str, Any], process: _Process) -> Fmu:
    """The description as values; numbers that are none become None or infinite."""
    try:
        found = table["description"]
        variables = tuple(
            FmuVariable(
                name=str(one["name"]),
                causality=str(one["causality"]),
                variability=str(one["variability"]),
                start=_number(one["start"], None),
                low=_number(one["low"], -math.inf) or 0.0,  # never None
                high=_number(one["high"], math.inf) or 0.0,
                unit=str(one["unit"]),
            )
            for one in found["variables"]
        )
        interfaces = tuple(str(one) for one in found["interfaces"])
        step_s = _number(found["step_s"], None)
        return Fmu(
            path, str(found["version"]), str(found["name"]), interfaces, variables, step_s, process
        )
    except (KeyError, TypeError):
        raise process.broken() from None


def _number(text: Any, instead: float | None) -> float | None:
    try:
        found = float(text)
    except (TypeError, ValueError):
        return instead
    return instead if math.isnan(found) else found
