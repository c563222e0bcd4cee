"""The words keep to the program: links lead somewhere, what is named is there."""

from __future__ import annotations

import argparse
import itertools
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from servosight.app.parser import parser
from servosight.models.core import InputError
from servosight.models.effects import Place, catalogue
from servosight.scenarios.draws import SHOWN_ALONE, effect_of
from servosight.scenarios.scenario import Scenario

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ +(.+)$", re.MULTILINE)
FENCE = re.compile(r"^ *```(\w*)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"^ {4,}(?:\$ )?(servosight .*)$", re.MULTILINE)
INLINE = re.compile(r"(?<!`)`(servosight [^`]+)`(?!`)")
FOLDERS = (
    "app|bench|benchmarks|diagnose|docs|export|identify|models|scenarios|sim|sources|src|tests"
    "|tools|tracking"
)
FILE = re.compile(rf"(?<![\w/.-])(?:{FOLDERS})/[\w./*-]*[\w*/]")
REFERENCE = re.compile(r"^(:{3,4}) (servosight[\w.]*)$", re.MULTILINE)
COUNT = re.compile(r"\b([2-9]\d)\s+(?:further\s+)?effects\b(?!\s+of\s+then)(\s+is\s+hidden)?")
PLACES = re.compile(r"\bone of (\w+) places\b")
NUMBERS = ("eight", "nine", "ten", "eleven", "twelve")
"""Number words from eight on."""
FALL = re.compile(r"error on test data falls from ([\d.]+) deg to ([\d.]+) deg")
"""What the README's demo prints of its ladder."""
MAKE = re.compile(r"(?:`|^ {4,}(?:\$ )?)make ([a-z][\w-]*)", re.MULTILINE)

pages = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())


def slug(heading: str) -> str:
    """A heading's anchor as GitHub makes it."""
    plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", plain.strip().lower()).replace(" ", "-")


def whole_commands(text: str) -> Iterator[str]:
    """Lines of the terminal, without what is said behind them."""
    lines = [match[1] for match in INDENTED.finditer(FENCE.sub("", text))]
    for match in FENCE.finditer(text):
        lines += re.findall(r"^ *(?:\$ )?(servosight .*)$", match[2], re.MULTILINE)
    for line in lines:
        yield re.split(r"   | +#", line)[0].strip()


def below(above: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """The parsers of a parser's commands or actions, by name."""
    lists = [one for one in above._actions if isinstance(one, argparse._SubParsersAction)]
    return dict(lists[0].choices) if lists else {}


def known_options(words: list[str]) -> set[str]:
    """The options of a command, or of its action where one is named; KeyError for no command."""
    command = below(parser())[words[0]]
    action = below(command).get(words[1] if len(words) > 1 else "")
    parsers = [action] if action else [command, *below(command).values()]
    return {option for one in parsers for option in one._option_string_actions}


@pages
def test_links_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for link in LINK.findall(FENCE.sub("", text)):
        if link.startswith(("https://", "http://")):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name) if name else page
        assert target.exists(), f"{page.name} links to {link}"
        if anchor:
            headings = HEADING.findall(target.read_text(encoding="utf-8"))
            assert anchor in map(slug, headings), f"{page.name} links to {link}"


@pages
def test_files_named_are_there(page: Path) -> None:
    for name in FILE.findall(page.read_text(encoding="utf-8")):
        assert any(ROOT.glob(name.rstrip("/"))), f"{page.name} names {name}"


@pages
def test_targets_of_make_are_there(page: Path) -> None:
    targets = re.findall(
        r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert set(MAKE.findall(page.read_text(encoding="utf-8"))) <= set(targets)


@pages
def test_commands_and_flags_named_are_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for words in [*INLINE.findall(text), *whole_commands(text)]:
        name, *more = words.split()[1:]
        if name.startswith("-") or name.isupper():  # servosight --help, servosight COMMAND
            continue
        assert name in below(parser()), f"{page.name}: {words}"
        flags = set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", words))
        assert flags <= known_options([name, *more]), f"{page.name}: {words}"


@pages
def test_lines_of_the_terminal_are_understood(page: Path) -> None:
    for words in whole_commands(page.read_text(encoding="utf-8")):
        if "[" in words or "..." in words:  # a form, not a line to type
            continue
        try:
            parser().parse_args(shlex.split(words)[1:])
        except (InputError, SystemExit) as error:
            pytest.fail(f"{page.name}: {words}: {error}")


@pages
def test_scenarios_shown_are_read(page: Path, tmp_path: Path) -> None:
    for language, body in FENCE.findall(page.read_text(encoding="utf-8")):
        if language == "toml" and "duration_s =" in body:
            path = tmp_path / "scenario.toml"
            path.write_text(body, encoding="utf-8")
            Scenario.load(path)


@pages
def test_counts_of_effects_are_those_of_the_catalogue(page: Path) -> None:
    """What was measured with an earlier catalogue says "of then"."""
    if page.name == "CHANGELOG.md" or page.parent.name == "measured":
        return
    for count, hidden in COUNT.findall(page.read_text(encoding="utf-8")):
        assert int(count) == len(SHOWN_ALONE if hidden else catalogue()), f"{page.name}: {count}"


def test_the_architecture_counts_and_lists_the_places_of_effects() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    (word,) = PLACES.findall(text)
    assert NUMBERS.index(word) + 8 == len(Place)
    table = text.split("| place | between |")[1].split("\n\n")[0]
    rows = [line.split("|")[1] for line in table.splitlines()[2:]]
    listed = [name.strip() for row in rows for name in row.split(",")]
    assert sorted(listed) == sorted(place.value for place in Place)


def test_every_page_is_in_the_index() -> None:
    """A folder that is linked stands for its pages."""
    index = ROOT / "docs" / "README.md"
    linked = {(index.parent / link).resolve() for link in LINK.findall(index.read_text("utf-8"))}
    pages = {page for page in PAGES if page.is_relative_to(ROOT / "docs")} - {index}
    missing = [page.name for page in pages if not linked & {page, page.parent}]
    assert missing == [], "a line for each into docs/README.md"


def test_the_reference_lists_packages_and_modules_that_are_there() -> None:
    named = [
        REFERENCE.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))
        for page in ("api.md", "api-packages.md")
    ]
    assert all(named)
    for colons, name in itertools.chain(*named):
        place = ROOT / "src" / Path(*name.split("."))
        is_package = (place / "__init__.py").is_file()
        assert is_package if colons == "::::" else place.with_suffix(".py").is_file(), name


def test_every_package_has_its_line_in_the_architecture() -> None:
    """Those directly in a top folder; what is deeper stands in their lines."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    places = sorted((ROOT / "src" / "servosight").glob("[a-z]*/*/__init__.py"))
    packages = ["/".join(place.parent.parts[-2:]) for place in places]
    assert len(packages) > 40
    assert [name for name in packages if f"`{name}/`" not in text] == []


def test_every_command_is_in_the_readme() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [name for name in below(parser()) if f"servosight {name}" not in text] == []


def test_the_demo_hides_what_the_readme_prints() -> None:
    """Its output is not run with the other examples, since it films."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = re.search(
        r"servosight demo .*--seed (\d+)\n.*?What was hidden: (\w+)\.", text, re.DOTALL
    )
    assert shown is not None
    assert effect_of(int(shown[1])) == shown[2]


@pytest.mark.parametrize("page", ["accuracy.md", "search.md"])
def test_pages_quote_the_demo_as_the_readme_prints_it(page: str) -> None:
    printed = FALL.search((ROOT / "README.md").read_text(encoding="utf-8"))
    quoted = FALL.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))
    assert printed is not None
    assert quoted == [printed.groups()]


def test_the_summary_of_hidden_effects_has_the_measured_numbers() -> None:
    """Goal, share, interval and count of each row, as `make hidden` wrote them."""
    summary, whole = (
        {tuple(cell.strip() for cell in line.split("|")[2:6]) for line in text.splitlines()}
        for text in (
            section("accuracy.md", "## Hidden effects, named"),
            (ROOT / "docs" / "measured" / "hidden.md").read_text(encoding="utf-8"),
        )
    )
    rows = {row for row in summary if len(row) == 4 and row[1].endswith("%")}
    assert len(rows) > 5
    assert rows - whole == set()


def section(page: str, heading: str) -> str:
    """What stands between a heading and the next of its level."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return text.split(f"{heading}\n")[1].split("\n## ")[0]
