"""Which flags a user gave."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from typing import Any

from circumspect.errors import InputError

_NUMBER = re.compile(r"-?(?:\d+(?:\.\d*)?(?:e[+-]?\d+)?|nan|inf)")


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


@contextmanager
def flags_named(command: Any, *names: str) -> Iterator[None]:
    """Name the flag in a fault that tells but its value: "slip is …, not 0.9".

    What checks a value is used without a command line, too, and knows nothing of flags. Where
    several flags have the value none is named.

    Args:
        command: A dataclass, parsed.
        names: Of its fields whose values are checked.

    Raises:
        InputError: In the place of the one that was raised.
    """
    try:
        yield
    except InputError as error:
        _, found, refused = str(error).rpartition(", not ")
        numbers = [f"{float(number):g}" for number in _NUMBER.findall(refused)]
        refusals = [name for name in names if _numbers(getattr(command, name)) == numbers]
        culprits = given_flags(command, *refusals) if refusals else []
        if not (found and numbers) or len(culprits) != 1:
            raise
        raise InputError(f"{culprits[0]}: {error}") from error


def _numbers(value: Any) -> list[str]:
    """As a message may tell it."""
    values = value if isinstance(value, tuple) else (value,)
    return [f"{number:g}" for number in values if isinstance(number, int | float)]
