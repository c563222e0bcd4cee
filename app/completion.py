"""What a shell asks for while a command is typed."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable
from typing import Any

ASKED = "_ARGCOMPLETE"
"""Set by the shell's script while it asks."""


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer a shell that asks for completions, and end the process; else do nothing."""
    if ASKED in os.environ:
        from argcomplete import autocomplete

        autocomplete(parser, always_complete_options=False)


def with_effects(action: argparse.Action) -> None:
    """Let the names of the catalogue's effects complete an argument."""
    action.completer = _effects  # type: ignore[attr-defined]


def with_names(action: argparse.Action, names: Iterable[str]) -> None:
    """Let ``names`` complete an argument."""
    action.completer = lambda **context: list(names)  # type: ignore[attr-defined]


def _effects(prefix: str, **context: Any) -> list[str]:
    """Names that go on with ``prefix``, of which the last of several after commas counts."""
    from servosight.models.effects import catalogue

    done, comma, _ = prefix.rpartition(",")
    return [f"{done}{comma}{name}" for name in catalogue()]
