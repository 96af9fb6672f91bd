"""Result of one image, and of all simultaneous images."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose
from circumspect.localization.tag_pose import TagPose

TRACKED = "tracked"
"""At least one camera sees the robot."""
BRIDGED = "bridged"
"""No camera sees it, or they contradict each other: the pose is predicted."""
LOST = "lost"
"""The prediction is too old, or there was no measurement yet: there is no pose."""
NO_TAG = "the tag is not in view"
MOVED = "moved since calibration"


@dataclass(frozen=True, eq=False)
class Sighting:
    """Result of one image.

    Attributes:
        camera: Name of the camera.
        stamp: Time of the image [s].
        pose: Measured pose of the robot; None without a valid measurement.
        reason: Why the pose is missing or not used, as a constant text for counting; None if it is
            used.
        detail: Variable part of the reason: numbers, other tags.
        others: Unknown tags in the image.
    """

    camera: str
    stamp: float
    pose: TagPose | None = None
    reason: str | None = None
    others: tuple[int, ...] = ()
    detail: str | None = None

    @property
    def full_reason(self) -> str | None:
        """Reason with its detail."""
        return self.reason if self.detail is None else f"{self.reason} ({self.detail})"

    @property
    def used(self) -> bool:
        """Whether the pose is part of the fused pose."""
        return self.pose is not None and self.reason is None

    def summary(self) -> dict[str, Any]:
        """The sighting as JSON types."""
        document: dict[str, Any] = {"camera": self.camera, "stamp": self.stamp, "used": self.used}
        if self.reason is not None:
            document["reason"] = self.full_reason
        if self.others:
            document["unknown_tags"] = list(self.others)
        if self.pose is not None:
            pose = self.pose.T_map_base
            document |= {
                "x": round(pose.x, 5),
                "y": round(pose.y, 5),
                "yaw_deg": round(float(np.degrees(pose.yaw)), 4),
                "squared_residual": round(self.pose.squared_residual, 2),
            }
        return document


@dataclass(frozen=True, eq=False)
class SpaceFix:
    """Result of all simultaneous images.

    Attributes:
        stamp: Time [s].
        state: `TRACKED`, `BRIDGED` or `LOST`.
        T_map_base: Pose of the robot; None if lost.
        covariance: (3, 3) of x, y [m] and yaw [rad]; None if lost.
        sightings: Result of each camera.
        note: What is wrong; None if nothing is.
    """

    stamp: float
    state: str
    T_map_base: PlanarPose | None
    covariance: NDArray[np.float64] | None
    sightings: tuple[Sighting, ...] = ()
    note: str | None = None

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the cameras that are used."""
        return tuple(sighting.camera for sighting in self.sightings if sighting.used)

    @property
    def position_sigma(self) -> float:
        """Standard deviation of the position, root of the sum over both axes [m]; NaN if lost."""
        if self.covariance is None:
            return float("nan")
        return float(np.sqrt(self.covariance[0, 0] + self.covariance[1, 1]))

    @property
    def yaw_sigma(self) -> float:
        """Standard deviation of the heading [rad]; NaN if lost."""
        return float("nan") if self.covariance is None else float(np.sqrt(self.covariance[2, 2]))

    def summary(self) -> dict[str, Any]:
        """One line of the log as JSON types."""
        document: dict[str, Any] = {"stamp": self.stamp, "state": self.state}
        if self.T_map_base is not None:
            pose = self.T_map_base
            document |= {
                "x": round(pose.x, 5),
                "y": round(pose.y, 5),
                "yaw_deg": round(float(np.degrees(pose.yaw)), 4),
                "position_sigma_m": round(self.position_sigma, 6),
                "yaw_sigma_deg": round(float(np.degrees(self.yaw_sigma)), 4),
            }
        document["cameras"] = list(self.cameras)
        document["rejected"] = {
            s.camera: s.full_reason for s in self.sightings if s.reason is not None
        }
        if self.note is not None:
            document["note"] = self.note
        document["sightings"] = [sighting.summary() for sighting in self.sightings]
        return document
