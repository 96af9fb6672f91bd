"""What one image said of the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from circumspect.localization.tag_pose import TagPose

NO_TAG = "the tag is not in view"
MOVED = "moved since calibration"


@dataclass(frozen=True, eq=False)
class Sighting:
    """One camera's word.

    Attributes:
        camera: Its name.
        stamp: Time of the image [s].
        pose: Where it sees the robot; None where it sees none, or none that can be believed.
        reason: Why the pose is missing or was not used, the same words each time, by which it is
            counted; None where it was used.
        detail: Of the reason, what differs from image to image: numbers, other tags.
        others: Tags in the image that belong to nobody known.
    """

    camera: str
    stamp: float
    pose: TagPose | None = None
    reason: str | None = None
    others: tuple[int, ...] = ()
    detail: str | None = None

    @property
    def why(self) -> str | None:
        """The reason and its detail."""
        return self.reason if self.detail is None else f"{self.reason} ({self.detail})"

    @property
    def used(self) -> bool:
        """Whether it took part in the fused pose."""
        return self.pose is not None and self.reason is None

    def summary(self) -> dict[str, Any]:
        """JSON types."""
        told: dict[str, Any] = {"camera": self.camera, "stamp": self.stamp, "used": self.used}
        if self.reason is not None:
            told["reason"] = self.why
        if self.others:
            told["unknown_tags"] = list(self.others)
        if self.pose is not None:
            pose = self.pose.T_map_base
            told |= {
                "x": round(pose.x, 5),
                "y": round(pose.y, 5),
                "yaw_deg": round(float(np.degrees(pose.yaw)), 4),
                "misfit": round(self.pose.misfit, 2),
            }
        return told
