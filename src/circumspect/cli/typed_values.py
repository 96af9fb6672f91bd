"""Checks values of a file, and converts them to the types of flags."""

from __future__ import annotations

import types
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

SIMPLE = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}


class WrongTypeError(Exception):
    """A value has the wrong type; the message describes the expected type."""


def typed_value(hint: Any, value: Any) -> Any:
    """Convert a value of TOML or YAML to the type of a flag.

    Args:
        hint: `bool`, `int`, `float`, `str`, `Path`, a `Literal`, a tuple of these, or a union of
            one of these and None.
        value: The value.

    Raises:
        WrongTypeError: The value has another type.
    """
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return typed_value(inner[0], value)
    if origin in (Union, types.UnionType):
        return _optional(inner, value)
    if origin is Literal:
        if isinstance(value, str) and value in inner:
            return value
        raise WrongTypeError(f"one of {', '.join(inner)}")
    if origin is tuple:
        return _listed(inner, value)
    if hint is Path:
        return Path(typed_value(str, value))
    wanted = (int, float) if hint is float else hint
    # Python's bool is a subclass of int; here it is no number.
    if not isinstance(value, wanted) or (isinstance(value, bool) and hint is not bool):
        raise WrongTypeError(SIMPLE[hint])
    return hint(value)


def _optional(kinds: tuple[Any, ...], value: Any) -> Any:
    """A value of `T | None`; null of YAML means the same as a missing key."""
    (kind,) = (kind for kind in kinds if kind is not types.NoneType)
    return None if value is None else typed_value(kind, value)


def _listed(kinds: tuple[Any, ...], value: Any) -> tuple[Any, ...]:
    open_ended = kinds[-1] is Ellipsis
    if not isinstance(value, list) or not (open_ended or len(value) == len(kinds)):
        raise WrongTypeError("a list" if open_ended else f"a list of {len(kinds)}")
    each = kinds[:1] * len(value) if open_ended else kinds
    try:
        return tuple(typed_value(kind, one) for kind, one in zip(each, value, strict=True))
    except WrongTypeError as error:
        raise WrongTypeError(f"a list, each of it {error}") from error
