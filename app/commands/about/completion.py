"""Print the script that lets a shell complete commands, options and effects."""

from __future__ import annotations

import argparse

SHELLS = ("bash", "zsh", "fish")


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight completion``."""
    parser.add_argument("shell", choices=SHELLS, help="the shell to write the script for")
    parser.epilog = (
        'bash and zsh: eval "$(servosight completion bash)" in .bashrc or .zshrc; '
        "fish: servosight completion fish > ~/.config/fish/completions/servosight.fish"
    )


def run(args: argparse.Namespace) -> None:
    """Print the script."""
    from argcomplete.shell_integration import shellcode

    print(shellcode(["servosight"], shell=args.shell))
