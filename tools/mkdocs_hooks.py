"""Hooks of mkdocs: README.md and CONTRIBUTING.md become pages, and links between pages are kept.

In the repository a page links to ``../README.md``, which is outside mkdocs's folder. Here the two
pages are added under names of their own, links to them are rewritten, and links to other files
outside the folder become plain text. A line ``:::: servosight.models.core`` becomes a ``:::`` of
mkdocstrings for each name that the ``__init__.py`` of the package offers.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
ADDED = {"tour.md": "README.md", "contributing.md": "CONTRIBUTING.md"}
FACES = "__init__.pyi", "__init__.py"
MEMBERS = re.compile(r"^:::: (servosight[\w.]*)$", re.MULTILINE)
IN_HTML = re.compile(r'href="([\w-]+)\.md(#[^"]*)?">([\w-]+\.md)?')
LINK = re.compile(r"\[([^]]*)\]\(([^)#\s]+)(#[^)\s]*)?\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that stand in the project's root."""
    from mkdocs.structure.files import File

    for name, source in ADDED.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Rewrite links from the repository's layout to the site's."""
    name = page.file.src_uri
    folder = (ROOT / ADDED[name]).parent if name in ADDED else (ROOT / "docs" / name).parent
    depth = "../" * name.count("/")

    def rewritten(match: re.Match[str]) -> str:
        text, target, anchor = match[1], match[2], match[3] or ""
        if "://" in target:
            return match[0]
        place = (folder / target).resolve()
        for added, source in ADDED.items():
            if place == ROOT / source:
                text = title(place) if text.endswith(".md") else text
                return f"[{text}]({depth}{added}{anchor})"
        if not place.is_relative_to(ROOT / "docs"):
            return text
        if place.suffix == ".md" and text.endswith(".md") and place.is_file():
            text = title(place)
        if place == ROOT / "docs":
            place /= "README.md"
        elif place.is_dir():  # a folder stands for its pages
            place = min(place.glob("*.md"))
        return f"[{text}]({depth}{place.relative_to(ROOT / 'docs').as_posix()}{anchor})"

    return LINK.sub(rewritten, MEMBERS.sub(members, markdown))


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """A notebook's links to pages, which its plugin leaves as they are in the repository."""
    if not page.file.src_uri.endswith(".ipynb"):
        return html

    def linked(match: re.Match[str]) -> str:
        shown = title(ROOT / "docs" / match[3]) if match[3] else ""
        return f'href="../{match[1]}/{match[2] or ""}">{shown}'

    return IN_HTML.sub(linked, html)


def title(page: Path) -> str:
    """A page's heading, which readers of the site know it by."""
    first = page.read_text(encoding="utf-8").partition("\n")[0]
    return first.removeprefix("# ")


def members(match: re.Match[str]) -> str:
    """A directive for each name that a package offers, in alphabetical order."""
    package = match[1]
    folder = ROOT / "src" / Path(*package.split("."))
    source = next(path for path in map(folder.joinpath, FACES) if path.exists())
    stub = source.suffix == ".pyi"  # there, every import is an offer
    names = {
        alias.name
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if stub or alias.asname == alias.name
    }
    return "\n\n".join(f"::: {package}.{name}" for name in sorted(names))
