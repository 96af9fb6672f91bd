"""Floors in files of objects: removed on request, reported otherwise."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect.cli.say import say

if TYPE_CHECKING:
    from circumspect.classification import Prediction
    from circumspect.geometry import PointCloud
    from circumspect.geometry.floor_cut import FloorCut

HINT = "seems to hold the floor, too; cut it off: --cut-floor"


@dataclass(frozen=True, eq=False)
class ObjectToName:
    """The object of a file, prepared for classification.

    Attributes:
        cloud: Its points, levelled if a floor was removed.
        up_unknown: Whether the upward direction is unknown.
        record: Entries added to the answer of `--json`.
    """

    cloud: PointCloud
    up_unknown: bool
    record: dict[str, Any] = field(default_factory=dict)


def object_to_name(file: Path, cloud: PointCloud, up: str | None, cut_floor: bool) -> ObjectToName:
    """Remove the floor if requested; its normal also gives the upward direction.

    Args:
        file: File for messages.
        cloud: Content of the file.
        up: Value of `--up`.
        cut_floor: Whether `--cut-floor` was given.
    """
    auto = up == "auto"
    cut = _floor_cut_of(file, cloud, auto) if cut_floor else None
    if cut is None:
        return ObjectToName(cloud, auto)
    record: dict[str, Any] = {"floor": _floor_record(cut)}
    if auto:
        record["up_xyz"] = cut.plane.normal_xyz.round(4).tolist()
    return ObjectToName(cut.levelled(), False, record)


def _floor_cut_of(file: Path, cloud: PointCloud, any_way_up: bool) -> FloorCut | None:
    """Find the object and the floor; None without a floor. Either result is printed."""
    from circumspect.geometry.floor_cut import cut_floor

    cut = cut_floor(cloud)
    if cut is None and any_way_up:
        cut = cut_floor(cloud, any_way_up=True)
    if cut is None:
        say(f"{file}: no floor found; nothing was cut off")
        return None
    others = f" and {cut.other_points} beside the object" if cut.other_points else ""
    level = f", tilted by {math.degrees(cut.tilt):.0f}°" if cut.tilt > math.radians(1.0) else ""
    say(
        f"{file}: cut off {cut.floor_points} points of the floor{level}{others}; "
        f"{len(cut.cloud)} of {len(cut.kept)} are left"
    )
    return cut


def _floor_record(cut: FloorCut) -> dict[str, Any]:
    return {
        "floor_points": cut.floor_points,
        "other_points": cut.other_points,
        "tilt_deg": round(math.degrees(cut.tilt), 2),
        "normal_xyz": cut.plane.normal_xyz.round(4).tolist(),
        "offset": round(cut.plane.offset, 6),
    }


def print_floor_hint(
    file: Path, cloud: PointCloud, any_way_up: bool, prediction: Prediction
) -> None:
    """Print a hint to `--cut-floor` if a cloud seems to contain the floor.

    The quick test finds a level floor below the object. The thorough test, for tilted or noisy
    floors and floors elsewhere, runs only if the answer is not confident.
    """
    from circumspect.classification.cloud_checks import holds_floor

    found = not any_way_up and holds_floor(cloud.points_xyz)
    if not found and not prediction.confident:
        from circumspect.geometry.floor_cut import cut_floor

        found = cut_floor(cloud, any_way_up=any_way_up) is not None
    if found:
        say(f"{file}: {HINT}")
