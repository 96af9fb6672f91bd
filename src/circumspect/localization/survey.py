"""Where tags lie on the floor, as somebody measured it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from circumspect.errors import InputError
from circumspect.localization.json_file import number, numbers, read_document, section
from circumspect.localization.tag_mount import require_tag_id
from circumspect.storage import write_json

POSITION_SIGMA = 0.001
YAW_SIGMA = float(np.radians(0.5))
FARTHEST = 1e8
"""No place on earth is so far from a map's origin, wherever that may be [m]."""
LARGEST_TAG_M = 5.0
"""No tag that lies on a floor is larger [m]."""
LONGEST_NUMBER = 9
"""Of a tag [digits]."""


@dataclass(frozen=True)
class SurveyedTag:
    """One tag that lies flat, face up.

    Attributes:
        x, y, z: Of its middle in map [m].
        yaw: Of the direction to the right of the print [rad]; None where nobody measured it.
    """

    x: float
    y: float
    z: float = 0.0
    yaw: float | None = None


@dataclass(frozen=True)
class Survey:
    """Tags on the floor.

    Attributes:
        size: Side of their black squares [m].
        tags: By number.
        position_sigma: Of a measured place, along each axis [m].
        yaw_sigma: Of a measured direction [rad].

    Raises:
        InputError: No tag, one that is nowhere on earth, or a size or sigma that is not positive.
    """

    size: float
    tags: Mapping[int, SurveyedTag]
    position_sigma: float = POSITION_SIGMA
    yaw_sigma: float = YAW_SIGMA

    def __post_init__(self) -> None:
        if not self.tags:
            raise InputError("the survey holds no tag")
        for tag_id, tag in self.tags.items():
            require_tag_id(tag_id)
            require_on_earth(f"tag {tag_id}", (tag.x, tag.y, tag.z))
        for name in ("size", "position_sigma", "yaw_sigma"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"the survey's {name} must be positive")
        _require_size(self.size)


def _require_size(size: float) -> None:
    """Check that tags of a size [m] can be printed: more are centimetres or millimetres."""
    if size > LARGEST_TAG_M:
        raise InputError(
            f"the tags' size is {size:g} m; give metres (tag_size_m, and x, y and z of the tags)"
        )


def require_on_earth(what: str, place_xyz: Sequence[float]) -> None:
    """Check that something can be where somebody says.

    Args:
        what: It, for the message.
        place_xyz: (3,) [m] in map.

    Raises:
        InputError: It can not.
    """
    if not max(map(abs, place_xyz)) < FARTHEST:
        told = ", ".join(f"{value:g}" for value in place_xyz)
        raise InputError(f"{what} is at ({told}) m: nowhere on earth; give metres")


def write_survey(path: str | os.PathLike[str], survey: Survey) -> None:
    """Write a survey as JSON.

    Raises:
        OutputError: The file can not be written.
    """
    tags: dict[str, Any] = {}
    for tag_id, tag in survey.tags.items():
        tags[str(tag_id)] = {"x": tag.x, "y": tag.y, "z": tag.z}
        if tag.yaw is not None:
            tags[str(tag_id)]["yaw_deg"] = float(np.degrees(tag.yaw))
    head = {
        "tag_size_m": survey.size,
        "position_sigma_m": survey.position_sigma,
        "yaw_sigma_deg": float(np.degrees(survey.yaw_sigma)),
    }
    write_json(path, {**head, "tags": tags})


def read_survey(path: str | os.PathLike[str]) -> Survey:
    """Read a survey: `{"tag_size_m": …, "tags": {"10": {"x": …, "y": …, "yaw_deg": …}, …}}`.

    "z" and "yaw_deg" of a tag may be missing, and so may "position_sigma_m" and "yaw_sigma_deg".

    Raises:
        InputError: The file can not be read, or is no such document.
    """
    with read_document(path) as document:
        tags = {}
        for name in section(document, "tags"):
            if not name.isdecimal() or len(name) > LONGEST_NUMBER:
                raise InputError(f"tags are named by their numbers, not '{name[:20]}'")
            entry = section(section(document, "tags"), name)
            yaw = entry.get("yaw_deg")
            tags[int(name)] = SurveyedTag(
                number(entry, "x"),
                number(entry, "y"),
                number(entry, "z", 0.0),
                None if yaw is None else float(np.radians(numbers(entry, "yaw_deg", 1)[0])),
            )
        return Survey(
            number(document, "tag_size_m"),
            tags,
            number(document, "position_sigma_m", POSITION_SIGMA),
            float(np.radians(number(document, "yaw_sigma_deg", float(np.degrees(YAW_SIGMA))))),
        )
