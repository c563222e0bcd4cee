"""Run damaged inputs through the command line, and shrink those that end badly.

A failure is an exit code other than 0 and 2, more than one sentence with exit code 2, a traceback,
a signal, more than 60 s, more than 2 GB, or a temporary that is left behind.
"""

from __future__ import annotations

import argparse
import base64
import json
import os
import select
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Lock
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from fuzz.cases import Case, cases
from fuzz.inputs import write_inputs

LONGEST_S = 60.0
LARGEST_BYTES = 2 << 30
ATTEMPTS = 80
"""Runs that are spent on making one failure smaller."""


@dataclass(frozen=True)
class Failure:
    """A case that ended badly, and why."""

    case: Case
    why: str


@dataclass
class Tally:
    """How many cases ended how, and the failures."""

    ends: Counter[str] = field(default_factory=Counter)
    failures: list[Failure] = field(default_factory=list)
    slowest_s: float = 0.0


class Worker:
    """A process that runs cases, started anew whenever one has ended it."""

    def __init__(self, valid: Path) -> None:
        self.valid = valid
        self.process: subprocess.Popen[bytes] | None = None

    def run(self, case: Case) -> tuple[str, str | None, float]:
        """How a case ended, why that is a failure (None: it is none), and the time it took [s]."""
        process = self.process or self._start()
        assert process.stdin is not None
        assert process.stdout is not None
        request = {
            "line": list(case.line),
            "file": case.file,
            "data": base64.b64encode(case.data).decode(),
            "largest_file": case.largest_file,
        }
        process.stdin.write(json.dumps(request).encode() + b"\n")
        process.stdin.flush()
        ready, _, _ = select.select([process.stdout], [], [], LONGEST_S)
        reply = process.stdout.readline() if ready else b""
        if reply:
            return _judged(json.loads(reply))
        self.close()
        if not ready:
            return "hung", f"took more than {LONGEST_S:g} s", LONGEST_S
        return "died", f"the process ended with {process.returncode}", 0.0

    def close(self) -> None:
        """End the process."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None

    def _start(self) -> subprocess.Popen[bytes]:
        self.process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("worker.py")), str(self.valid)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"},
        )
        return self.process


def fuzz(todo: Iterable[Case], valid: Path, workers: int, talk: bool = False) -> Tally:
    """Run all cases on some workers; failures come with their smallest reproducer."""
    tally, shared, lock = Tally(), iter(todo), Lock()

    def work() -> None:
        worker = Worker(valid)
        try:
            while True:
                with lock:
                    case = next(shared, None)
                if case is None:
                    return
                _one(worker, case, tally, talk)
        finally:
            worker.close()

    with ThreadPoolExecutor(workers) as pool:
        for done in [pool.submit(work) for _ in range(workers)]:
            done.result()
    return tally


def _one(worker: Worker, case: Case, tally: Tally, talk: bool) -> None:
    end, why, seconds = worker.run(case)
    tally.ends[end] += 1
    tally.slowest_s = max(tally.slowest_s, seconds)
    if why is not None:
        known = {_kind(failure.why) for failure in tally.failures}
        smallest = case if _kind(why) in known else shrunk(worker, case, end)
        tally.failures.append(Failure(smallest, why))
        if talk and _kind(why) not in known:
            print(f"{why}\n    {str(smallest)[:1500]}", flush=True)
    total = sum(tally.ends.values())
    if talk and total % 500 == 0:
        print(f"{total}: {dict(tally.ends)}", file=sys.stderr, flush=True)


def shrunk(worker: Worker, case: Case, end: str) -> Case:
    """The smallest case found that ends in the same way, by leaving words and lines out."""
    left = ATTEMPTS if end != "hung" else 3
    smaller = _smaller(case)
    while left and (candidate := next(smaller, None)) is not None:
        left -= 1
        if worker.run(candidate)[0] == end:
            case, smaller = candidate, _smaller(candidate)
    return case


def _smaller(case: Case) -> Iterator[Case]:
    """Cases with less in them: each without one word, then without ever shorter runs of lines."""
    for index in range(len(case.line) - 1, 0, -1):
        yield replace(case, line=case.line[:index] + case.line[index + 1 :])
    lines = case.data.splitlines(keepends=True)
    size = len(lines) // 2
    while size:
        for first in range(0, len(lines), size):
            yield replace(case, data=b"".join(lines[:first] + lines[first + size :]))
        size //= 2


def _judged(reply: dict[str, Any]) -> tuple[str, str | None, float]:
    code, said, seconds = reply["code"], reply["said"], reply["seconds"]
    end = f"exit {code}"
    if code not in (0, 2):
        return end, f"exit code {code}: {said.strip()}", seconds
    if "Traceback" in said:
        return "traceback", f"a traceback: {said.strip()[-300:]}", seconds
    last = [line for line in said.splitlines() if not line.startswith("note: ")]
    if code == 2 and (len(last) != 1 or not last[0].startswith("servosight: ")):
        return "wordy", f"not one sentence: {said.strip()[:300]}", seconds
    if seconds > LONGEST_S:
        return "slow", f"took {seconds:.0f} s", seconds
    if reply["bytes"] > LARGEST_BYTES:
        return "large", f"needed {reply['bytes'] / 1e9:.1f} GB", seconds
    if reply["hidden"]:
        return "left", f"left {reply['hidden'][0]} behind", seconds
    return end, None, seconds


def _kind(why: str) -> str:
    """What is alike in failures of one cause: the words, without numbers and names."""
    return "".join(c for c in why.split("(")[-1] if c.isalpha() or c == " ")[:60]


def main() -> int:
    """Run as many cases as asked; exit code 1 where one failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as place:
        valid = Path(place)
        write_inputs(valid)
        tally = fuzz(cases(args.count, args.seed, valid), valid, args.workers, talk=True)
    ends = ", ".join(f"{end}: {count}" for end, count in tally.ends.most_common())
    print(f"{sum(tally.ends.values())} inputs in {time.perf_counter() - began:.0f} s; {ends}")
    print(f"{len(tally.failures)} failures; the slowest took {tally.slowest_s:.1f} s")
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
