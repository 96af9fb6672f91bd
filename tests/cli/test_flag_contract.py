"""The flags of all commands and their defaults, which others' scripts rely on, are in flags.txt."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from circumspect.cli.flag_table import REQUIRED, flags_of
from circumspect.cli.main import COMMANDS, command

FILE = Path(__file__).with_name("flags.txt")


def lines() -> Iterator[str]:
    """Command, flag and default, sorted by the flag."""
    for name in COMMANDS:
        kind = command(name)
        kinds = getattr(kind, "COMMANDS", None)
        meant = {name: kind} if kinds is None else {f"{name} {one}": kinds[one] for one in kinds}
        for called, own in meant.items():
            for flag in sorted(flags_of(own)):
                default = flags_of(own)[flag].default
                shown = "required" if default is REQUIRED else repr(default)
                yield f"{called} --{flag.replace('_', '-')} {shown}"


def test_flags_and_defaults() -> None:
    found = list(lines())
    if "--rewrite" in sys.argv:
        FILE.write_text("\n".join(found) + "\n")
    remedy = "where this is meant: PYTHONPATH=src python tests/cli/test_flag_contract.py --rewrite"
    assert found == FILE.read_text().splitlines(), remedy


if __name__ == "__main__":
    sys.exit(pytest.main([__file__, "-q"]))
