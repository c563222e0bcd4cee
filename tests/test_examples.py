"""The examples in the documents run, in a folder of their own, and print what the documents say.

An example is an indented ``$ `` line and its output below, where ``...`` stands for lines left out.
Files shown in a fenced block whose introduction ends with their name are written before. Words must
agree, numbers to 5 %: another processor rounds differently. To bring the printed lines up to date:
``SERVOSIGHT_REWRITE=1 .venv/bin/python -m pytest tests/test_examples.py``, then read the diff.
"""

from __future__ import annotations

import difflib
import math
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from servosight.app.main import main
from servosight.models.core import BEST_SO_FAR

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
PROMPT = re.compile(r"^( {4,})\$ (.+)$")
FENCE = re.compile(r"^ *```(\w*)$")
NAMED = re.compile(r"`([\w-]+\.(?:py|toml|csv))`[^`]*:$")
NUMBER = re.compile(r"[-+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")
DRAWN = re.compile(r"[─▏▎▍▌▋▊▉█]+")
LEFT_OUT = {
    "servosight demo": "films; tests/test_story.py tells the same story",
    "servosight simulate servo.toml": "films; tests/test_docs.py reads the scenario",
    "servosight import": "reads a log that is not here; tests/app and tests/models import logs",
    "servosight diagnose fit": "needs the recordings of a real servo",
    "servosight diagnose stop": "minutes each; tests/diagnose/discrepancy/test_law.py",
}


@dataclass(frozen=True)
class File:
    """A file that a page shows in full."""

    name: str
    text: str


@dataclass(frozen=True)
class Example:
    """A command and the lines that a page prints below it; ``at`` is the first one's number."""

    command: str
    at: int
    printed: tuple[str, ...]


def parts(page: Path) -> Iterator[File | Example]:
    """Files and examples in the order of the page."""
    lines = page.read_text(encoding="utf-8").splitlines()
    i, above = 0, ""
    while i < len(lines):
        if FENCE.match(lines[i]):
            end = next(j for j in range(i + 1, len(lines)) if lines[j].strip() == "```")
            if named := NAMED.search(above):
                yield File(named[1], "\n".join(lines[i + 1 : end]) + "\n")
            i = end + 1
        elif prompt := PROMPT.match(lines[i]):
            end = i + 1
            while end < len(lines) and (
                not lines[end]
                or (lines[end].startswith(prompt[1]) and not PROMPT.match(lines[end]))
            ):
                end += 1
            printed = tuple(line[len(prompt[1]) :].rstrip() for line in lines[i + 1 : end])
            yield Example(prompt[2], i + 1, printed)
            i = end
        else:
            above = lines[i] or above
            i += 1


def run(command: str, folder: Path, capfd: pytest.CaptureFixture[str]) -> list[str]:
    """What the command prints, on both streams, but for the progress of a search."""
    words = shlex.split(command, comments=True)
    if words[0] == "python":
        done = subprocess.run([sys.executable, *words[1:]], cwd=folder, check=False, timeout=120)
        code = done.returncode
    else:
        assert words[0] == "servosight"
        code = main(words[1:])
    output = "".join(reversed(capfd.readouterr()))
    refused = output.startswith("servosight: ") and code == 2
    assert code == 0 or refused, f"{command}: exit code {code}\n{output}"
    lines = [line.rstrip() for line in output.splitlines()]
    return [line for line in lines if not line.startswith(BEST_SO_FAR)]


def same(printed: str, line: str) -> bool:
    """Whether two lines have the same words, and numbers that agree to 5 %."""
    one, other = (NUMBER.sub("#", DRAWN.sub("", text)).split() for text in (printed, line))
    return one == other and all(
        math.isclose(a, b, rel_tol=0.05, abs_tol=2e-4)
        for a, b in zip(*(numbers(text) for text in (printed, line)), strict=True)
    )


def numbers(text: str) -> list[float]:
    return [float(number.replace(",", "").rstrip(".")) for number in NUMBER.findall(text)]


def wanted(example: Example) -> list[int]:
    """The indices of the printed lines that the output must have."""
    return [i for i, line in enumerate(example.printed) if line.strip() not in ("", "...")]


def rewritten(example: Example, output: list[str]) -> dict[int, str]:
    """Each printed line that matters, replaced by the most similar line of the output."""
    return {
        i: max(
            output,
            key=lambda line, old=example.printed[i]: difflib.SequenceMatcher(
                None, old, line
            ).ratio(),
        )
        for i in wanted(example)
    }


@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if any(isinstance(part, Example) for part in parts(page))],
    ids=lambda page: page.relative_to(ROOT).as_posix(),
)
def test_examples_print_what_the_page_says(
    page: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    changes: dict[int, str] = {}
    for part in parts(page):
        if isinstance(part, File):
            (tmp_path / part.name).write_text(part.text, encoding="utf-8")
        elif not part.command.startswith(tuple(LEFT_OUT)):
            output = run(part.command, tmp_path, capfd)
            rest = iter(output)
            missing = [
                i for i in wanted(part) if not any(same(part.printed[i], line) for line in rest)
            ]
            if missing and "SERVOSIGHT_REWRITE" in os.environ:
                changes |= {part.at + i: line for i, line in rewritten(part, output).items()}
                continue
            assert not missing, (
                f"{page.name}: $ {part.command}\nnot printed: {part.printed[missing[0]]!r}\n"
                + "\n".join(output)
            )
    if changes:
        lines = page.read_text(encoding="utf-8").splitlines()
        for i, line in changes.items():
            lines[i] = lines[i][: len(lines[i]) - len(lines[i].lstrip())].ljust(4)[:4] + line
        page.write_text("\n".join(lines) + "\n", encoding="utf-8")
