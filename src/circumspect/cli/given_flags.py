"""Which flags a user gave."""

from __future__ import annotations

from dataclasses import fields
from typing import Any


def given_flags(command: Any, *names: str) -> list[str]:
    """Those of a command's fields that say something, as they are typed.

    A value that is the default is as good as none.

    Args:
        command: A dataclass, parsed.
        names: Of its fields; none means all.
    """
    usual = {field.name: field.default for field in fields(command)}
    said = [name for name in names or usual if getattr(command, name) != usual[name]]
    return [f"--{name.strip('_').replace('_', '-')}" for name in said]
