"""Access to JSON documents; errors name the file and the entry."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from circumspect.errors import InputError, reason_of

MAX_BYTES = 16 << 20


@contextmanager
def read_document(path: str | os.PathLike[str]) -> Iterator[dict[str, Any]]:
    """Read the object of a file; errors in the block are reported with its name.

    Raises:
        InputError: The file cannot be read, or is not a JSON object.
    """
    file = Path(path)
    try:
        try:
            if file.exists() and not file.is_file() and not file.is_dir():
                raise InputError("is not a regular file")
            if file.stat().st_size > MAX_BYTES:
                raise InputError("is too large")
            document = json.loads(file.read_text(encoding="utf-8"))
        except OSError as error:
            raise InputError(f"can not be read ({reason_of(error)})") from error
        except (ValueError, RecursionError) as error:
            raise InputError(f"is not JSON ({str(error).splitlines()[0]})") from error
        if not isinstance(document, dict):
            raise InputError(f"is not a JSON object but a {type(document).__name__}")
        yield document
    except InputError as error:
        raise type(error)(f"{file}: {error}") from error


def section(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Read an object entry.

    Raises:
        InputError: It is missing or not an object.
    """
    found = document.get(name)
    if not isinstance(found, dict):
        raise InputError(f"needs an object '{name}'{_instead(document, name)}")
    return found


def text(document: Mapping[str, Any], name: str) -> str:
    """Read a text entry.

    Raises:
        InputError: It is missing or not a text.
    """
    found = document.get(name)
    if not isinstance(found, str):
        raise InputError(f"needs a text '{name}'{_instead(document, name)}")
    return found


def number(document: Mapping[str, Any], name: str, default: float | None = None) -> float:
    """Read an entry with a finite number.

    Raises:
        InputError: It is missing without a default, or is not a finite number.
    """
    if default is not None and name not in document:
        return default
    return numbers(document, name, 1)[0]


def numbers(document: Mapping[str, Any], name: str, count: int) -> list[float]:
    """Read an entry with a list of finite numbers, or a single one.

    Raises:
        InputError: The entry is missing, of another length, or not finite.
    """
    found = document.get(name)
    listed = found if isinstance(found, list) and count > 1 else [found]
    good = [value for value in map(_finite, listed) if value is not None]
    if len(good) != len(listed) or len(good) != count:
        what = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(f"needs {what} '{name}'{_instead(document, name)}")
    return good


def _finite(value: Any) -> float | None:
    """The value as a finite number; None if it is none."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None
    try:
        return float(value) if math.isfinite(value) else None
    except OverflowError:
        return None


def _instead(document: Mapping[str, Any], name: str) -> str:
    if name in document:
        return f", has {json.dumps(document[name])[:60]}"
    return f"; it has: {', '.join(map(str, document))}"[:200]
