"""Surveyed positions of tags on the floor."""

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
MAX_COORDINATE_M = 1e8
"""Maximum coordinate of a position on earth [m]."""
MAX_TAG_SIZE_M = 5.0
"""Maximum size of a tag [m]."""
MAX_DIGITS = 9
"""Maximum number of digits of a tag number."""


@dataclass(frozen=True)
class SurveyedTag:
    """A tag that lies flat, face up.

    Attributes:
        x, y, z: Position of its centre in map [m].
        yaw: Direction to the right of the print [rad]; None if not measured.
    """

    x: float
    y: float
    z: float = 0.0
    yaw: float | None = None


@dataclass(frozen=True)
class Survey:
    """Surveyed tags on the floor.

    Attributes:
        size: Side of the black squares [m].
        tags: Tags by number.
        position_sigma: Standard deviation of a measured position along each axis [m].
        yaw_sigma: Standard deviation of a measured direction [rad].

    Raises:
        InputError: There is no tag, a position is implausible, or a size or sigma is not positive.
    """

    size: float
    tags: Mapping[int, SurveyedTag]
    position_sigma: float = POSITION_SIGMA
    yaw_sigma: float = YAW_SIGMA

    def __post_init__(self) -> None:
        if not self.tags:
            raise InputError("the survey contains no tag")
        for tag_id, tag in self.tags.items():
            require_tag_id(tag_id)
            require_plausible_position(f"tag {tag_id}", (tag.x, tag.y, tag.z))
        for name in ("size", "position_sigma", "yaw_sigma"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"the survey's {name} must be positive")
        _require_size(self.size)


def _require_size(size: float) -> None:
    """Check that a tag size [m] is plausible; larger ones are centimetres or millimetres."""
    if size > MAX_TAG_SIZE_M:
        raise InputError(
            f"the tags' size is {size:g} m; give metres (tag_size_m, and x, y and z of the tags)"
        )


def require_plausible_position(what: str, place_xyz: Sequence[float]) -> None:
    """Check that coordinates are plausible metres.

    Args:
        what: Name for the message.
        place_xyz: (3,) position in map [m].

    Raises:
        InputError: They are too large.
    """
    if not max(map(abs, place_xyz)) < MAX_COORDINATE_M:
        coordinates = ", ".join(f"{value:g}" for value in place_xyz)
        raise InputError(f"{what} is at ({coordinates}) m, too far away; give metres")


def write_survey(path: str | os.PathLike[str], survey: Survey) -> None:
    """Write a survey as JSON.

    Raises:
        OutputError: The file cannot be written.
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

    The entries "z" and "yaw_deg" of a tag, "position_sigma_m" and "yaw_sigma_deg" are optional.

    Raises:
        InputError: The file cannot be read or is not a survey.
    """
    with read_document(path) as document:
        tags = {}
        for name in section(document, "tags"):
            if not name.isdecimal() or len(name) > MAX_DIGITS:
                raise InputError(f"tags must be named by their numbers, not '{name[:20]}'")
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
