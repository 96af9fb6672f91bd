"""Checks of an untrusted bag before a library reads it."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from circumspect.errors import InputError
from circumspect.recording.ros_types import COMPRESSED_IMAGE, IMAGE

MAX_INDEX_BYTES = 4 << 20
"""Maximum size of a YAML index [bytes]."""
MAX_ARRAY_LENGTH = 1 << 20
"""Maximum length of a fixed-length array in a message."""
MAX_TABLES = 100
MAX_MESSAGE_BYTES = 4 << 20
"""Maximum size of a message other than an image [bytes]; decoded, it takes many times as much."""
MAX_IMAGE_BYTES = 200 << 20
"""Maximum size of an image message [bytes]."""
_COMPUTED = re.compile(r"\b(?:AS|VIRTUAL)\b", re.IGNORECASE)
_ALIAS = re.compile(rb"(?:^|[\s\[{,:-])\*\w+\s*(?:$|[\s,\]}])")
_INDEX, _SQLITE = "metadata.yaml", b"SQLite format 3\0"


def require_plain_bag(path: Path) -> None:
    """Check the files of a bag.

    Raises:
        InputError: It is not a regular file, has a huge index, or is a database whose rows are
            computed, so that a few bytes could yield endless rows.
    """
    if path.is_dir():
        index = path / _INDEX
        if index.exists() and (not index.is_file() or index.stat().st_size > MAX_INDEX_BYTES):
            raise InputError(
                f"{path}: its {_INDEX} is not a file of at most {MAX_INDEX_BYTES} bytes"
            )
        _require_no_aliases(index)
        files = [file for file in path.iterdir() if file.name != _INDEX]
    else:
        files = [path]
    for file in files:
        if file.exists() and not file.is_file() and not file.is_dir():
            raise InputError(f"{file}: is not a regular file")
        if file.is_file():
            _require_stored_rows(file)


def _require_no_aliases(index: Path) -> None:
    """Refuse YAML aliases: nested aliases are short in the file but huge when expanded."""
    if index.exists() and _ALIAS.search(index.read_bytes()):
        raise InputError(f"{index}: holds references (*name), which no recorder writes")


def _require_stored_rows(file: Path) -> None:
    with file.open("rb") as stream:
        if stream.read(len(_SQLITE)) != _SQLITE:
            return  # Another kind, compressed or broken: the library reports it.
    try:
        base = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
        base.text_factory = lambda text: text.decode("latin-1")
        try:
            rows = base.execute("SELECT type, sql FROM sqlite_master").fetchmany(MAX_TABLES + 1)
        finally:
            base.close()
    # SQLite's error messages may contain bytes of the file that are not text.
    except (sqlite3.Error, UnicodeDecodeError) as error:
        raise InputError(f"{file}: is a broken database ({error})") from error
    if len(rows) > MAX_TABLES:
        raise InputError(f"{file}: has more than {MAX_TABLES} tables, unlike any recording")
    for kind, text in rows:
        if kind not in ("table", "index") or _COMPUTED.search(str(text or "")):
            raise InputError(f"{file}: is a database with computed rows, not a recording")


def require_possible_size(kind: str, size: int) -> None:
    """Check the size of a message before it is decoded.

    Args:
        kind: Message type.
        size: Length of the message [bytes].

    Raises:
        InputError: The message is larger than the limit of its type.
    """
    largest = MAX_IMAGE_BYTES if kind in (IMAGE, COMPRESSED_IMAGE) else MAX_MESSAGE_BYTES
    if size > largest:
        raise InputError(f"a {kind} of {size} bytes exceeds the limit of {largest}")


def require_bounded_messages(definitions: Mapping[str, Any]) -> None:
    """Check the message types that are defined in a bag.

    Args:
        definitions: Type to (constants, fields), as in rosbags.

    Raises:
        InputError: A field is an array of an empty type or a very long array: a message of a few
            bytes could then decode to billions of elements.
    """
    for name, (_, fields) in definitions.items():
        for field, (node, detail) in fields:
            if node.name not in ("ARRAY", "SEQUENCE"):
                continue
            (inner, kind), length = detail
            if node.name == "ARRAY" and length > MAX_ARRAY_LENGTH:
                raise InputError(
                    f"{name}.{field} has {length} elements, more than any known message"
                )
            if inner.name == "NAME" and not _takes_room(kind, definitions, ()):
                raise InputError(f"{name}.{field} is an array of an empty type")


def _takes_room(name: str, definitions: Mapping[str, Any], within: tuple[str, ...]) -> bool:
    """Whether a message of a type takes at least one byte."""
    if name not in definitions or name in within or len(within) > 64:
        return False
    for _, (node, detail) in definitions[name][1]:
        if node.name in ("BASE", "SEQUENCE"):
            return True
        inner = detail if node.name == "NAME" else detail[0][1]
        if node.name == "ARRAY" and (detail[1] == 0 or detail[0][0].name == "BASE"):
            if detail[1]:
                return True
            continue
        if _takes_room(inner, definitions, (*within, name)):
            return True
    return False
