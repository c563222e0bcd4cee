"""The examples in docstrings run, each module's in a folder of its own."""

from __future__ import annotations

import doctest
import importlib
import inspect
from pathlib import Path

import pytest

import servosight

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


@pytest.mark.parametrize("name", [one for one in dir(servosight) if not one.startswith("_")])
def test_examples_of_the_interface_run_as_they_are_pasted(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """With all that they need imported, as in a session that has just begun."""
    monkeypatch.chdir(tmp_path)
    exported = getattr(servosight, name)
    if not inspect.isclass(exported) and not inspect.isfunction(exported):
        return
    for found in doctest.DocTestFinder().find(exported, name, globs={}):
        failed, _ = doctest.DocTestRunner(optionflags=FLAGS).run(found)
        assert failed == 0, capfd.readouterr().out
