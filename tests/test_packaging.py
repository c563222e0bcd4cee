"""The wheel holds what the tree holds, and imports run downward only."""

from __future__ import annotations

import ast
import importlib.metadata
import importlib.util
import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest

import servosight

PUBLIC = ("__main__.py", "__init__.py", "__init__.pyi", "py.typed")
"""What stands in src/servosight itself, beside the verbs."""
VERBS = "servosight/_verbs"
HEAVY = ("av", "control", "cv2", "matplotlib", "mujoco", "numba", "pyrender", "scipy")


@pytest.fixture(scope="module")
def pyproject(project_root: Path) -> dict[str, Any]:
    return tomllib.loads((project_root / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def folders(project_root: Path) -> list[str]:
    """The top-level folders that are packages, as the tree has them."""
    return sorted(init.parent.name for init in project_root.glob("*/__init__.py"))


@pytest.fixture(scope="module")
def in_tree(project_root: Path, folders: list[str]) -> set[str]:
    """Every file of the product as the tree has it, by its place in the wheel."""
    files = {"_servosight.py", *(f"servosight/{name}" for name in PUBLIC)}
    verbs = (project_root / "src" / VERBS).glob("*.py")
    files |= {f"{VERBS}/{path.name}" for path in verbs}
    for folder in folders:
        for path in (project_root / folder).rglob("*"):
            ignored = (
                path.is_dir() or "__pycache__" in path.parts or path.suffix in {".nbc", ".nbi"}
            )
            if not ignored:
                files.add(f"servosight/{path.relative_to(project_root).as_posix()}")
    return files


def build(project_root: Path, target: str, place: Path) -> Path:
    """Build the wheel or the sdist with the hatchling at hand: no isolation, no network."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(place)]
    done = subprocess.run(command, cwd=project_root, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (built,) = place.iterdir()
    return built


def test_wheel_holds_what_the_tree_holds(
    project_root: Path, in_tree: set[str], tmp_path: Path
) -> None:
    with zipfile.ZipFile(build(project_root, "wheel", tmp_path)) as wheel:
        in_wheel = {name for name in wheel.namelist() if ".dist-info/" not in name}
        (entry_points,) = (n for n in wheel.namelist() if n.endswith("entry_points.txt"))
        assert "servosight = _servosight:main" in wheel.read(entry_points).decode()
    assert in_wheel == in_tree


def test_sdist_holds_what_a_wheel_is_built_from(
    project_root: Path, in_tree: set[str], tmp_path: Path
) -> None:
    with tarfile.open(build(project_root, "sdist", tmp_path)) as sdist:
        names = {name.split("/", 1)[1] for name in sdist.getnames()}
    sources = {
        f"src/{name}"
        if name.count("/") < 2 or name.startswith(VERBS)
        else name.removeprefix("servosight/")
        for name in in_tree
    }
    assert sources | {"pyproject.toml", "hatch_build.py", "LICENSE", "README.md"} <= names


def test_every_list_names_every_folder(pyproject: dict[str, Any], folders: list[str]) -> None:
    targets = pyproject["tool"]["hatch"]["build"]["targets"]
    sources = dict(targets["wheel"]["sources"])
    assert sources.pop("src") == ""
    assert sources == {folder: f"servosight/{folder}" for folder in folders}
    assert {entry for entry in targets["wheel"]["only-include"] if "/" not in entry} == set(folders)
    assert set(folders) <= set(targets["sdist"]["only-include"])
    banned = pyproject["tool"]["ruff"]["lint"]["flake8-tidy-imports"]["banned-api"]
    assert sorted(banned) == folders


def test_every_folder_is_imported_from_the_tree(project_root: Path, folders: list[str]) -> None:
    for folder in folders:
        spec = importlib.util.find_spec(f"servosight.{folder}")
        assert spec is not None
        assert spec.origin is not None
        assert Path(spec.origin).resolve() == project_root / folder / "__init__.py"


def test_version_is_said_once() -> None:
    assert importlib.metadata.version("servosight") == servosight.__version__


@pytest.mark.parametrize("module", ["servosight", "servosight.app.main"])
def test_start_is_light(module: str) -> None:
    """``servosight --help`` answers at once: nothing heavy is imported before it is needed."""
    if importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not there yet")
    code = f"import sys, {module}; print([name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_lock_names_public_addresses_alone(project_root: Path) -> None:
    lock = (project_root / "uv.lock").read_text(encoding="utf-8")
    assert set(re.findall(r"https?://[^/\"]+", lock)) == {
        "https://pypi.org",
        "https://files.pythonhosted.org",
    }


def lint_imports(folder: Path, src: Path) -> subprocess.CompletedProcess[str]:
    """Hold the package under ``src`` against the contracts in ``folder``'s pyproject.toml."""
    code = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports())"
    return subprocess.run(
        [sys.executable, "-P", "-c", code],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(src)},
        capture_output=True,
        text=True,
        check=False,
    )


def write_package(project_root: Path, place: Path, folders: list[str]) -> Path:
    """A package of empty folders under ``place``, beside the project's own contracts."""
    text = (project_root / "pyproject.toml").read_text(encoding="utf-8")
    (place / "pyproject.toml").write_text(text, encoding="utf-8")
    package = place / "src" / "servosight"
    for folder in {*folders, "_verbs"}:
        (package / folder).mkdir(parents=True)
        (package / folder / "__init__.py").touch()
    for name in PUBLIC:
        (package / name).touch()
    return package


def test_imports_run_downward(project_root: Path) -> None:
    done = lint_imports(project_root, project_root / "src")
    assert done.returncode == 0, done.stdout + done.stderr


def test_private_modules_are_imported_by_their_own_package_alone(
    project_root: Path, folders: list[str]
) -> None:
    """``servosight.a._b`` belongs to ``servosight.a``; others import from its ``__init__``."""
    strangers = []
    for path in (path for folder in folders for path in (project_root / folder).rglob("*.py")):
        here = ".".join(("servosight", *path.relative_to(project_root).with_suffix("").parts))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                owner, private, _ = node.module.partition("._")
                if private and not f"{here}.".startswith(f"{owner}."):
                    strangers.append(f"{here} imports {node.module}")
    assert not strangers


def test_one_module_below_the_command_line_names_it(project_root: Path, folders: list[str]) -> None:
    """import-linter does not see an import by name; docs/architecture.md states this one."""
    files = [
        path
        for folder in folders
        if folder != "app"
        for path in (project_root / folder).rglob("*.py")
    ]
    named = [path for path in files if '"servosight.app' in path.read_text(encoding="utf-8")]
    assert [path.relative_to(project_root).as_posix() for path in named] == ["diagnose/_report.py"]


@pytest.mark.parametrize(
    ("importer", "imported", "allowed"),
    [
        ("app", "servosight.scenarios", True),
        ("scenarios", "servosight.sim", True),
        ("diagnose", "servosight.identify", True),
        ("sim", "servosight.models", True),
        ("sim", "mujoco", True),
        ("tracking", "cv2", True),
        ("export", "mujoco", True),
        ("export", "servosight.identify", False),
        ("export", "servosight.sim", False),
        ("models", "servosight.sim", False),
        ("models", "mujoco", False),
        ("models", "cv2", False),
        ("sim", "servosight.tracking", False),
        ("tracking", "servosight.sim", False),
        ("sim", "servosight.identify", False),
        ("tracking", "servosight.diagnose", False),
        ("identify", "servosight.sim", False),
        ("identify", "servosight.diagnose", False),
        ("identify", "mujoco", False),
        ("diagnose", "servosight.sim", False),
        ("diagnose", "servosight.tracking", False),
        ("scenarios", "servosight.app", False),
        ("bench", "servosight.models", True),
        ("bench", "servosight.sim", False),
        ("bench", "servosight.identify", False),
        ("a_new_folder", "servosight.models", False),
    ],
)
def test_the_contracts_bite(
    project_root: Path,
    folders: list[str],
    tmp_path: Path,
    importer: str,
    imported: str,
    allowed: bool,
) -> None:
    """A package of empty folders and one import: the contracts tell right from wrong."""
    package = write_package(project_root, tmp_path, [*folders, importer])
    (package / importer / "module.py").write_text(f"import {imported}\n", encoding="utf-8")
    done = lint_imports(tmp_path, tmp_path / "src")
    assert (done.returncode == 0) == allowed, done.stdout + done.stderr


def test_a_cycle_between_sub_packages_is_found(
    project_root: Path, folders: list[str], tmp_path: Path
) -> None:
    package = write_package(project_root, tmp_path, folders)
    for one, other in (("plant", "effects"), ("effects", "plant")):
        (package / "models" / one).mkdir()
        text = f"import servosight.models.{other}\n" if one == "plant" else ""
        (package / "models" / one / "__init__.py").write_text(text, encoding="utf-8")
    assert lint_imports(tmp_path, tmp_path / "src").returncode == 0
    text = "import servosight.models.plant\n"
    (package / "models" / "effects" / "__init__.py").write_text(text, encoding="utf-8")
    done = lint_imports(tmp_path, tmp_path / "src")
    assert done.returncode != 0
    assert "No cycles are allowed in servosight.models" in done.stdout
