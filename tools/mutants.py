"""A sample of a module's mutants, each run against the tests that concern it. Not part of CI.

    python tools/mutants.py diagnose/selection/_steps.py tests/diagnose/selection/test_stepwise.py \
        --sample 15 --seed 1 -k "not diagnosis"

A mutant is the module with one comparison, operator, number or condition changed. It is killed
where a test fails or the time limit ends, and survives where all pass: then a test is missing, or
the change means nothing.

The tests run on a copy of the tracked files in a temporary folder, one process and one thread each;
the working tree is not touched.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOADED_FIRST = ("numpy", "scipy.optimize", "scipy.signal", "numba", "msgspec", "pytest")
"""Loaded once, before the mutants' processes are forked."""

_COMPARED = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
}
_COMPUTED = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitOr: ast.BitAnd,
    ast.BitAnd: ast.BitOr,
}
_NAMES = {"min": "max", "max": "min", "all": "any", "any": "all", "argmin": "argmax"}
_MEANINGLESS = ("strict", "frozen", "kw_only", "repr", "eq", "axis", "dtype")
"""Keywords of which a change fails at once, or changes nothing that these modules mean."""
Change = Callable[[], None]


def sites(tree: ast.Module) -> list[tuple[int, Change]]:
    """Line and change of each mutant, in the order of the text; a change alters the tree."""
    found: list[tuple[int, Change]] = []
    for node in _code(tree):
        found += [(getattr(node, "lineno", 0), change) for change in _changes(node)]
    return found


def _code(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes that compute: no annotations, no words."""
    yield node
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.keyword) and child.arg in _MEANINGLESS:
                continue
            if isinstance(child, ast.AST):
                yield from _code(child)


def _changes(node: ast.AST) -> Iterator[Change]:
    if isinstance(node, ast.Compare):
        for place, op in enumerate(node.ops):
            other = _COMPARED[type(op)]
            yield lambda place=place, other=other: node.ops.__setitem__(place, other())
    elif isinstance(node, ast.BinOp) and type(node.op) in _COMPUTED:
        yield lambda: setattr(node, "op", _COMPUTED[type(node.op)]())
    elif isinstance(node, ast.BoolOp):
        other = ast.Or if isinstance(node.op, ast.And) else ast.And
        yield lambda: setattr(node, "op", other())
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool | int | float):
        old = node.value
        yield lambda: setattr(node, "value", not old if isinstance(old, bool) else old + 1)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        kept = ast.UAdd() if isinstance(node.op, ast.USub) else None
        yield lambda: _unsigned(node, kept)
    elif isinstance(node, ast.If | ast.IfExp | ast.While):
        yield lambda: setattr(node, "test", ast.UnaryOp(ast.Not(), node.test))
    elif isinstance(node, ast.comprehension) and node.ifs:
        yield lambda: node.ifs.clear()
    elif isinstance(node, ast.Name) and node.id in _NAMES:
        yield lambda: setattr(node, "id", _NAMES[node.id])
    elif isinstance(node, ast.Attribute) and node.attr in _NAMES:
        yield lambda: setattr(node, "attr", _NAMES[node.attr])


def _unsigned(node: ast.UnaryOp, kept: ast.unaryop | None) -> None:
    """Drop the minus; turn ``not x`` to ``not not x``."""
    if kept is None:
        node.operand = ast.UnaryOp(ast.Not(), node.operand)
    else:
        node.op = kept


def copied(target: Path) -> None:
    """The tracked files in ``target``, its source folders linked as an editable install does."""
    names = subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True).splitlines()
    for name in names:
        if name.endswith((".py", ".toml", ".pyi", ".csv", ".html", ".css", ".js")):
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, target / name)
    package = target / "src" / "servosight"
    for link in (ROOT / "src" / "servosight").iterdir():
        if link.is_symlink():
            (package / link.name).symlink_to(Path("..", "..", link.name))


def outcome(folder: Path, words: list[str], limit_s: int) -> tuple[bool, float]:
    """True where all tests pass within the limit of processor time; and the seconds they took."""
    began = os.times()
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s))
        os.chdir(folder)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        sys.dont_write_bytecode = True
        sys.path.insert(0, str(folder / "src"))
        import pytest

        code = 1
        try:
            code = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", *words]))
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    ended = os.times()
    spent = (
        ended.children_user + ended.children_system - began.children_user - began.children_system
    )
    return status == 0, spent


def main() -> None:
    """Print a line for each mutant that survives, and the count."""
    words = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    words.add_argument("module", type=Path)
    words.add_argument("tests", nargs="+")
    words.add_argument("--sample", type=int, default=15, help="how many mutants (default 15)")
    words.add_argument("--seed", type=int, default=0, help="of the sample")
    words.add_argument("-k", default="", help="which of the tests, as for pytest")
    args = words.parse_args()
    for name in ("OMP", "OPENBLAS", "NUMBA"):
        os.environ[f"{name}_NUM_THREADS"] = "1"
    for name in LOADED_FIRST:
        __import__(name)
    text = (ROOT / args.module).read_text()
    count = len(sites(ast.parse(text)))
    drawn = sorted(random.Random(args.seed).sample(range(count), min(args.sample, count)))
    chosen = [*args.tests, *(["-k", args.k] if args.k else [])]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copied(folder)
        passed, spent = outcome(folder, chosen, 600)
        if not passed:
            sys.exit(f"{args.module}: the tests fail without a mutant")
        print(f"{args.module}: {count} mutants, {len(drawn)} drawn; the tests take {spent:.1f} s")
        survived = 0
        for number in drawn:
            tree = ast.parse(text)
            line, change = sites(tree)[number]
            before = ast.unparse(tree).splitlines()
            change()
            after = ast.unparse(ast.fix_missing_locations(tree)).splitlines()
            (folder / args.module).write_text("\n".join(after) + "\n")
            alive, _ = outcome(folder, chosen, 10 + round(3.0 * spent))
            if alive:
                survived += 1
                old, new = next(two for two in zip(before, after, strict=True) if two[0] != two[1])
                print(f"  line {line} survives: {old.strip()}  ->  {new.strip()}", flush=True)
        print(f"{args.module}: {len(drawn) - survived} of {len(drawn)} killed", flush=True)


if __name__ == "__main__":
    main()
