"""Floors in the files of objects: cut off on request, reported otherwise."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect.cli.say import say

if TYPE_CHECKING:
    from circumspect.classification import Prediction
    from circumspect.geometry import PointCloud
    from circumspect.geometry.floor_cut import FloorCut

HINT = "seems to hold the floor, too; cut it off: --cut-floor"


def floor_cut_of(file: Path, cloud: PointCloud, any_way_up: bool) -> FloorCut | None:
    """Cut the floor off, and say what was removed.

    Args:
        file: For the message.
        cloud: What it holds.
        any_way_up: The floor may have any direction; one beneath is tried first.

    Returns:
        The object; None where no floor is found, which is said, too.
    """
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


def floor_record(cut: FloorCut) -> dict[str, Any]:
    """What `--json` prints of a floor that was cut off."""
    return {
        "floor_points": cut.floor_points,
        "other_points": cut.other_points,
        "tilt_deg": round(math.degrees(cut.tilt), 2),
        "normal_xyz": cut.plane.normal_xyz.round(4).tolist(),
        "offset": round(cut.plane.offset, 6),
    }


def say_of_floor(file: Path, cloud: PointCloud, any_way_up: bool, prediction: Prediction) -> None:
    """Hint at the flag where a cloud seems to hold the floor.

    The quick test looks for a level floor beneath. The thorough one, for floors that lean, are
    noisy or lie elsewhere, is made where the answer is not confident anyway.
    """
    from circumspect.classification.floor_left import holds_floor

    found = not any_way_up and holds_floor(cloud.points_xyz)
    if not found and not prediction.confident:
        from circumspect.geometry.floor_cut import cut_floor

        found = cut_floor(cloud, any_way_up=any_way_up) is not None
    if found:
        say(f"{file}: {HINT}")
