"""Parameter files as ROS 2 has them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from circumspect.errors import InputError, MissingExtraError, reason_of

LARGEST = 2**18
"""Bytes of a parameter file; larger ones are something else."""
DEEPEST = 20
"""Levels of nodes, names and lists."""
HELD = "ros__parameters"
EVERY_NODE = "/**"


def read_parameters(path: str | os.PathLike[str], node: str) -> dict[str, Any]:
    """The parameters that a file holds for a node.

    Args:
        path: YAML: names of nodes, below each `ros__parameters`, below it names and values. What
            stands under `/**` is for every node.
        node: The node's full name.

    Raises:
        InputError: It can not be read, is no parameter file, or holds nothing for the node.
        MissingExtraError: PyYAML is not installed.
    """
    document = _document(Path(path))
    found: dict[str, dict[str, Any]] = {}
    _collect(document, "", found, path)
    names = (EVERY_NODE, node.rsplit("/", 1)[-1], node.removeprefix("/"), node)
    meant = [found[name] for name in names if name in found]
    if not meant:
        raise InputError(
            f"{path}: holds no {HELD} for the node {node}, but for "
            f"{', '.join(found) or 'no node'}; give --name, or /** for any node"
        )
    return {name: value for one in meant for name, value in one.items()}


def _document(path: Path) -> Any:
    try:
        import yaml
    except ImportError as error:
        raise MissingExtraError("PyYAML", "ros2") from error
    try:
        with path.open("rb") as stream:
            data = stream.read(LARGEST + 1)
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    if len(data) > LARGEST:
        raise InputError(f"{path}: has more than {LARGEST} bytes; is it a parameter file?")
    try:
        _guard(yaml, data, path)
        return yaml.safe_load(data)
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
            raise InputError(f"{path}: has aliases (*name), which parameter files need not")
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise InputError(f"{path}: is nested deeper than {DEEPEST} levels")


def _collect(
    document: Any, name: str, found: dict[str, dict[str, Any]], path: str | os.PathLike[str]
) -> None:
    """Find the parameters of all nodes; namespaces may be nested."""
    if not isinstance(document, dict):
        raise InputError(f"{path}: is no parameter file; it holds nodes, below them {HELD}")
    for key, value in document.items():
        if key == HELD:
            if not isinstance(value, dict) or not all(isinstance(one, str) for one in value):
                raise InputError(f"{path}: {HELD} of {name or 'no node'} holds no names and values")
            found[name] = value
        else:
            _collect(value, f"{name}/{key}" if name else str(key), found, path)
