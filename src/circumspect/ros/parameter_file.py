"""Parameter files as ROS 2 has them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from circumspect.errors import InputError
from circumspect.sensing.guarded_yaml import read_yaml

LARGEST = 2**18
"""Bytes of a parameter file; larger ones are something else."""
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
    document = read_yaml(Path(path), LARGEST, "a parameter file", "ros2")
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
