"""YAML of strangers, checked before anything is built from it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from circumspect.errors import InputError, MissingExtraError, reason_of
from circumspect.sensing.regular_file import require_regular

MAX_LEVELS = 20
"""Levels of names and lists."""


def read_yaml(path: Path, max_bytes: int, what: str, extra: str, loader: Any = None) -> Any:
    """Read a document.

    Args:
        path: The file.
        max_bytes: A larger file is something else.
        what: What the file is meant to be, for messages, such as "a parameter file".
        extra: The extra of this package that installs PyYAML.
        loader: A `yaml.SafeLoader` or a subclass of it; None for that class itself. May be a
            function that returns one, called once PyYAML is there.

    Raises:
        InputError: It can not be read, is too large or no YAML, has aliases or is nested deeply.
        MissingExtraError: PyYAML is not installed.
    """
    try:
        import yaml
    except ImportError as error:
        raise MissingExtraError("PyYAML", extra) from error
    try:
        require_regular(path)
        with path.open("rb") as stream:
            data = stream.read(max_bytes + 1)
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    if len(data) > max_bytes:
        raise InputError(f"{path}: has more than {max_bytes} bytes; is it {what}?")
    if data.startswith(b"%YAML:"):
        # OpenCV's own directive is none of YAML's.
        data = data.partition(b"\n")[2]
    try:
        _guard(yaml, data, path)
        return yaml.load(data, yaml.SafeLoader if loader is None else loader())
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        where = "" if mark is None else f" at line {mark.line + 1}"
        raise InputError(f"{path}: is no YAML{where}") from error


def _guard(yaml: Any, data: bytes, path: Path) -> None:
    """Refuse what is small to write and large to read."""
    depth = 0
    for event in yaml.parse(data):
        # A few lines of aliases of aliases can stand for more than any memory holds.
        if isinstance(event, yaml.AliasEvent):
            raise InputError(f"{path}: has aliases (*name), which are not read")
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_LEVELS:
            raise InputError(f"{path}: is nested deeper than {MAX_LEVELS} levels")
