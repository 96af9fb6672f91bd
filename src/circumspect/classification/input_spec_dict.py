"""Read input specifications of any kind and version."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from circumspect.classification.grid_spec import GridSpec
from circumspect.classification.input_spec import InputSpec
from circumspect.classification.points_spec import PointsSpec
from circumspect.errors import InputError

_RENAMED = {"staggered": "dithered"}
"""Earlier name of an entry to its name."""


def with_current_names(document: Mapping[str, Any]) -> dict[str, Any]:
    """Rename the entries of an input specification that an earlier version wrote.

    Args:
        document: See `InputSpec.to_dict`.

    Raises:
        InputError: It holds an entry under both names.
    """
    if both := [old for old, new in _RENAMED.items() if {old, new} <= document.keys()]:
        raise InputError(f"'{both[0]}' is the earlier name of '{_RENAMED[both[0]]}'; keep one")
    return {_RENAMED.get(name, name): value for name, value in document.items()}


def input_spec_from_dict(document: Mapping[str, Any]) -> InputSpec:
    """Read what `InputSpec.to_dict` returned, also of earlier versions.

    Raises:
        InputError: Unknown entries, or values out of range.
    """
    if not isinstance(document, Mapping):
        raise InputError(f"the settings of inputs must be an object, not {document!r:.40}")
    document = with_current_names(document)
    kind = PointsSpec if document.get("kind") == "points" else GridSpec
    known = {field.name for field in fields(kind)}
    if unknown := set(document) - known:
        raise InputError(f"unknown settings {sorted(unknown)}; known: {sorted(known)}")
    return kind(**document)
