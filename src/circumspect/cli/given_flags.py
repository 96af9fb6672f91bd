"""Flags that a user gave, and flags in error messages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from circumspect.cli.flag_table import Flag, flags_of
from circumspect.errors import InputError

_NUMBER = re.compile(r"-?(?:\d+(?:\.\d*)?(?:e[+-]?\d+)?|nan|inf)")


def given_flags(command: Any, *names: str) -> list[str]:
    """The flags of a command whose values differ from their defaults, as they are typed.

    Args:
        command: Parsed data class.
        names: Names of flags, or of settings for all their flags; none means all flags.
    """
    flags = flags_of(type(command)).values()
    selected = [flag for name in names for flag in flags if name in (flag.name, flag.path[0])]
    given = [flag.typed for flag in selected or flags if flag.value(command) != flag.default]
    return list(dict.fromkeys(given))


@contextmanager
def flags_named(command: Any, *names: str) -> Iterator[None]:
    """Add the flag to an error message that has only its value: "slip is …, not 0.9".

    The library that checks a value does not know the flags. If several flags have the value, none
    is added.

    Args:
        command: Parsed data class.
        names: Names of the flags whose values are checked.

    Raises:
        InputError: With the flag, instead of the original error.
    """
    flags = [flags_of(type(command))[name] for name in names]
    with culprit_named(flags, {flag.name: flag.value(command) for flag in flags}):
        yield


@contextmanager
def culprit_named(flags: Iterable[Flag], values: Mapping[str, Any]) -> Iterator[None]:
    """Like `flags_named`, for a command that is not built yet.

    Args:
        flags: Flags whose values are checked.
        values: Their values, by name.

    Raises:
        InputError: With the flag, instead of the original error.
    """
    try:
        yield
    except InputError as error:
        _, found, refused = str(error).rpartition(", not ")
        numbers = [f"{float(number):g}" for number in _NUMBER.findall(refused)]
        culprits = [
            flag.typed
            for flag in flags
            if _numbers(values[flag.name]) == numbers and values[flag.name] != flag.default
        ]
        if not (found and numbers) or len(culprits) != 1:
            raise
        raise InputError(f"{culprits[0]}: {error}") from error


def _numbers(value: Any) -> list[str]:
    """The numbers of a value as error messages quote them."""
    values = value if isinstance(value, tuple) else (value,)
    return [f"{number:g}" for number in values if isinstance(number, int | float)]


def drawn_seed(given: int | None) -> int:
    """The given seed, or a new random one.

    Raises:
        InputError: The seed is negative.
    """
    import numpy as np

    if given is not None and given < 0:
        raise InputError(f"--seed {given}: give a whole number of at least 0")
    return int(np.random.default_rng().integers(2**31)) if given is None else given
