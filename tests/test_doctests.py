"""The examples in docstrings run, each module's in a folder of its own."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "servosight"
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def modules() -> list[str]:
    """The modules that hold an example, by name; ``src/servosight`` links to the source folders."""
    folders = sorted(init.parent for init in ROOT.glob("*/__init__.py"))
    paths = [PACKAGE / "__init__.py", *PACKAGE.glob("_*/*.py")]
    paths += [path for folder in folders for path in sorted(folder.rglob("*.py"))]
    names = []
    for path in sorted(set(paths)):
        if ">>> " in path.read_text(encoding="utf-8"):
            base = PACKAGE if path.is_relative_to(PACKAGE) else ROOT
            parts = path.relative_to(base).with_suffix("").parts
            names.append(".".join(("servosight", *parts)).removesuffix(".__init__"))
    return names


@pytest.mark.parametrize("name", modules())
def test_examples_in_docstrings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(name)
    skipped = "doctest: +SKIP" in Path(str(module.__file__)).read_text(encoding="utf-8")
    failed, tried = doctest.testmod(module, optionflags=FLAGS)
    assert tried > 0 or skipped
    assert failed == 0, capfd.readouterr().out
