"""Documents in JSON, with errors that name the file and the entry."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from circumspect.errors import InputError, reason_of

MOST_BYTES = 16 << 20


@contextmanager
def read_document(path: str | os.PathLike[str]) -> Iterator[dict[str, Any]]:
    """The file's object; whatever the block finds wrong with it is told with the file's name.

    Raises:
        InputError: The file can not be read, or holds no JSON object.
    """
    file = Path(path)
    try:
        try:
            if file.exists() and not file.is_file() and not file.is_dir():
                raise InputError("is not a regular file")
            if file.stat().st_size > MOST_BYTES:
                raise InputError("is too large to be meant")
            document = json.loads(file.read_text(encoding="utf-8"))
        except OSError as error:
            raise InputError(f"can not be read ({reason_of(error)})") from error
        except (ValueError, RecursionError) as error:
            raise InputError(f"is no JSON ({str(error).splitlines()[0]})") from error
        if not isinstance(document, dict):
            raise InputError(f"holds no JSON object but a {type(document).__name__}")
        yield document
    except InputError as error:
        raise type(error)(f"{file}: {error}") from error


def section(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """An object in an object.

    Raises:
        InputError: It is missing or no object.
    """
    found = document.get(name)
    if not isinstance(found, dict):
        raise InputError(f"needs an object '{name}'{_instead(document, name)}")
    return found


def text(document: Mapping[str, Any], name: str) -> str:
    """A string in an object.

    Raises:
        InputError: It is missing or no string.
    """
    found = document.get(name)
    if not isinstance(found, str):
        raise InputError(f"needs a text '{name}'{_instead(document, name)}")
    return found


def number(document: Mapping[str, Any], name: str, default: float | None = None) -> float:
    """A finite number in an object.

    Raises:
        InputError: It is missing and there is no default, or it is no finite number.
    """
    if default is not None and name not in document:
        return default
    return numbers(document, name, 1)[0]


def numbers(document: Mapping[str, Any], name: str, count: int) -> list[float]:
    """So many finite numbers in an object: a list, or a single one by itself.

    Raises:
        InputError: They are missing, not so many, or not finite numbers.
    """
    found = document.get(name)
    listed = found if isinstance(found, list) and count > 1 else [found]
    good = [value for value in map(_finite, listed) if value is not None]
    if len(good) != len(listed) or len(good) != count:
        what = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(f"needs {what} '{name}'{_instead(document, name)}")
    return good


def _finite(value: Any) -> float | None:
    """A number as such; None for anything else, and for what is too large."""
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
