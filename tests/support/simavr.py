"""The board's firmware in simavr, behind a pseudo-terminal, as something that a clock drives."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from servosight.bench.firmware import build_firmware
from servosight.models.core import Array

HZ = 16_000_000
SLICE_S = 5e-4
SOURCE = Path(__file__).with_name("simavr_board.c")


def missing() -> str:
    """What is not installed of avr-gcc, a C compiler and simavr's library; empty where all is."""
    lacking = [name for name in ("avr-gcc", "avr-objcopy", "cc") if shutil.which(name) is None]
    if not Path("/usr/include/simavr/sim_avr.h").exists():
        lacking.append("libsimavr-dev")
    return ", ".join(lacking)


class SimavrBoard:
    """An ATmega328P with the firmware. ``edges`` has (time in s, level) for the two pins."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        """Take a simulator that has just started."""
        assert process.stdout is not None
        self._process = process
        self.path = process.stdout.readline().strip()
        self._start_s: float | None = None
        self._edges: dict[str, list[tuple[int, int]]] = {"P": [], "L": []}

    def pump(self, now_s: float) -> float:
        """Run up to now; ask to be called again soon."""
        if self._start_s is None:
            self._start_s = now_s
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        stdin.write(f"{round((now_s - self._start_s) * HZ)}\n")
        stdin.flush()
        while (words := stdout.readline().split()) != ["="]:
            name, cycle, level = words
            edges = self._edges[name]
            if level != str(edges[-1][1] if edges else 0):
                edges.append((int(cycle), int(level)))
        return now_s + SLICE_S

    def edges(self, pin: str) -> tuple[Array, Array]:
        """Times since the simulation's start, in s, at which a pin rose and at which it fell."""
        cycles = np.array(self._edges[pin], dtype=np.float64).reshape(-1, 2)
        high = cycles[:, 1] == 1
        return cycles[high, 0] / HZ, cycles[~high, 0] / HZ


@contextmanager
def simavr_board(folder: Path) -> Iterator[SimavrBoard]:
    """Compile firmware and simulator into ``folder``, and run them."""
    elf, simulator = folder / "board.elf", folder / "simavr_board"
    if not simulator.exists():
        build_firmware(folder)
        libraries = ["-lsimavr", "-lutil"]
        subprocess.run(["cc", "-O1", "-o", str(simulator), str(SOURCE), *libraries], check=True)
    process = subprocess.Popen(
        [str(simulator), str(elf)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield SimavrBoard(process)
    finally:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.close()
        process.wait(timeout=10)
        process.stdout.close()
