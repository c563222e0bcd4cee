"""The notebook of the documentation runs, and is committed with its pictures.

``SERVOSIGHT_REWRITE=1 .venv/bin/python -m pytest tests/test_notebook.py`` writes its outputs anew.
"""

from __future__ import annotations

import os
from pathlib import Path

import nbclient
import nbformat
import pytest

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "docs").rglob("*.ipynb"))


def pictures(notebook: nbformat.NotebookNode) -> int:
    outputs = (output for cell in notebook.cells for output in cell.get("outputs", []))
    return sum("image/png" in output.get("data", {}) for output in outputs)


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_the_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cell that raises ends it: the notebook checks what it finds by assertions of its own."""
    monkeypatch.delenv("MPLBACKEND", raising=False)  # the kernel draws into its outputs
    notebook = nbformat.read(path, as_version=4)
    committed = pictures(notebook)
    client = nbclient.NotebookClient(
        notebook, timeout=1800, resources={"metadata": {"path": tmp_path}}
    )
    manager = client.create_kernel_manager()
    manager.transport, manager.ip = "ipc", str(tmp_path / "kernel")  # no port is opened
    client.execute()
    if "SERVOSIGHT_REWRITE" in os.environ:
        nbformat.write(notebook, path)
    assert pictures(notebook) == committed > 0
