"""What is looked at before a bag of a stranger is handed to the library that reads it."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from circumspect.errors import InputError
from circumspect.recording.ros_types import COMPRESSED_IMAGE, IMAGE

LARGEST_INDEX = 4 << 20
"""An index in YAML of more bytes is something else."""
LONGEST_ARRAY = 1 << 20
"""Of a fixed length, in messages."""
MOST_TABLES = 100
LARGEST_MESSAGE = 4 << 20
"""Of any message but an image [bytes]; in memory its parts take many times as much."""
LARGEST_IMAGE = 200 << 20
"""Of a message with an image [bytes]."""
_COMPUTED = re.compile(r"\b(?:AS|VIRTUAL)\b", re.IGNORECASE)
_ALIAS = re.compile(rb"(?:^|[\s\[{,:-])\*\w+\s*(?:$|[\s,\]}])")
_INDEX, _SQLITE = "metadata.yaml", b"SQLite format 3\0"


def require_plain_bag(path: Path) -> None:
    """Check the files of a bag.

    Raises:
        InputError: It is no regular file, has a huge index, or a data base that computes what it
            holds, by which a few bytes could give rows without end.
    """
    if path.is_dir():
        index = path / _INDEX
        if index.exists() and (not index.is_file() or index.stat().st_size > LARGEST_INDEX):
            raise InputError(f"{path}: its {_INDEX} is no file of at most {LARGEST_INDEX} bytes")
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
    """A list of lists of lists, each named ten times, is short until somebody prints it."""
    if index.exists() and _ALIAS.search(index.read_bytes()):
        raise InputError(f"{index}: holds references (*name), which no recorder writes")


def _require_stored_rows(file: Path) -> None:
    with file.open("rb") as stream:
        if stream.read(len(_SQLITE)) != _SQLITE:
            return  # Of another kind, packed or broken: the library tells.
    try:
        base = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
        base.text_factory = lambda text: text.decode("latin-1")
        try:
            rows = base.execute("SELECT type, sql FROM sqlite_master").fetchmany(MOST_TABLES + 1)
        finally:
            base.close()
    # SQLite's own complaints may hold bytes of the file that are no text.
    except (sqlite3.Error, UnicodeDecodeError) as error:
        raise InputError(f"{file}: is a broken data base ({error})") from error
    if len(rows) > MOST_TABLES:
        raise InputError(f"{file}: has more than {MOST_TABLES} tables; no recording has")
    for kind, text in rows:
        if kind not in ("table", "index") or _COMPUTED.search(str(text or "")):
            raise InputError(f"{file}: a data base that computes its rows is no recording")


def require_possible_size(kind: str, size: int) -> None:
    """Check a message before it is decoded.

    Args:
        kind: Its type.
        size: Its length [bytes].

    Raises:
        InputError: No such message is as large.
    """
    largest = LARGEST_IMAGE if kind in (IMAGE, COMPRESSED_IMAGE) else LARGEST_MESSAGE
    if size > largest:
        raise InputError(f"a {kind} of {size} bytes; {largest} are read")


def require_bounded_messages(definitions: Mapping[str, Any]) -> None:
    """Check message types that a bag brings along.

    Args:
        definitions: Type to (constants, fields), as rosbags has them.

    Raises:
        InputError: Arrays of a type without content, or endless ones: a message of a few bytes
            could hold billions of elements.
    """
    for name, (_, fields) in definitions.items():
        for field, (node, detail) in fields:
            if node.name not in ("ARRAY", "SEQUENCE"):
                continue
            (inner, kind), length = detail
            if node.name == "ARRAY" and length > LONGEST_ARRAY:
                raise InputError(f"{name}.{field} has {length} elements; no message does")
            if inner.name == "NAME" and not _takes_room(kind, definitions, ()):
                raise InputError(f"{name}.{field} is an array of nothing; no message has one")


def _takes_room(name: str, definitions: Mapping[str, Any], within: tuple[str, ...]) -> bool:
    """Whether a message of that type takes at least a byte."""
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
