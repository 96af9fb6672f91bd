"""The help of every command as Markdown: the rest of the page "Command line"."""

from __future__ import annotations

import contextlib
import io
import os

PLACE = "<!-- help of every command -->"
SUBCOMMANDS = {"locate": ("simulate", "board", "intrinsics", "extrinsics", "track")}
COLUMNS = "80"


def add_command_help(_app, docname: str, text: list[str]) -> None:
    """Replace the mark in the page "Command line" by the help of the commands."""
    if docname == "cli":
        text[0] = text[0].replace(PLACE, command_help())


def command_help() -> str:
    """One section for each command and subcommand."""
    from circumspect.cli.main import COMMANDS

    parts = []
    for command in COMMANDS:
        parts.append(f"## {command}\n\n```text\n{help_of(command)}\n```\n")
        parts.extend(
            f"### {command} {sub}\n\n```text\n{help_of(command, sub)}\n```\n"
            for sub in SUBCOMMANDS.get(command, ())
        )
    return "\n".join(parts)


def help_of(*words: str) -> str:
    """What `circumspect WORDS --help` prints at 80 columns, without colours."""
    from circumspect.cli.main import main

    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = COLUMNS
    printed = io.StringIO()
    try:
        with contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
            main([*words, "--help"])
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before
    return "\n".join(line.rstrip() for line in printed.getvalue().strip().splitlines())
