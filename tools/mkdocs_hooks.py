"""Hooks of mkdocs: README.md and CONTRIBUTING.md become pages, and links between pages are kept.

In the repository a page links to ``../README.md``, which is outside mkdocs's folder. Here the two
pages are added under names of their own, links to them are rewritten, and links to other files
outside the folder become plain text.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
ADDED = {"tour.md": "README.md", "contributing.md": "CONTRIBUTING.md"}
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
                return f"[{text}]({depth}{added}{anchor})"
        if not place.is_relative_to(ROOT / "docs"):
            return text
        if place == ROOT / "docs":
            place /= "README.md"
        elif place.is_dir():  # a folder stands for its pages
            place = min(place.glob("*.md"))
        return f"[{text}]({depth}{place.relative_to(ROOT / 'docs').as_posix()}{anchor})"

    return LINK.sub(rewritten, markdown)
