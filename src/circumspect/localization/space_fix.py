"""Where the intelligent space says that the robot is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose
from circumspect.localization.sighting import Sighting

TRACKED = "tracked"
"""At least one camera saw it just now."""
BRIDGED = "bridged"
"""None did, or they contradict each other: the last motion goes on, with a growing covariance."""
LOST = "lost"
"""That has gone on for too long, or nothing was seen yet: there is no pose."""


@dataclass(frozen=True, eq=False)
class SpaceFix:
    """The answer to the images of one time.

    Attributes:
        stamp: Time [s].
        state: `TRACKED`, `BRIDGED` or `LOST`.
        T_map_base: The pose; None where it is lost.
        covariance: (3, 3) of x, y [m] and yaw [rad]; None where it is lost.
        sightings: What each camera said, and why it was not used.
        note: What was wrong on the whole; None where nothing was.
    """

    stamp: float
    state: str
    T_map_base: PlanarPose | None
    covariance: NDArray[np.float64] | None
    sightings: tuple[Sighting, ...] = ()
    note: str | None = None

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of those whose word was used."""
        return tuple(sighting.camera for sighting in self.sightings if sighting.used)

    @property
    def position_sigma(self) -> float:
        """Standard deviation of the place, root of the sum over both axes [m]; NaN if lost."""
        if self.covariance is None:
            return float("nan")
        return float(np.sqrt(self.covariance[0, 0] + self.covariance[1, 1]))

    @property
    def yaw_sigma(self) -> float:
        """Standard deviation of the heading [rad]; NaN if lost."""
        return float("nan") if self.covariance is None else float(np.sqrt(self.covariance[2, 2]))

    def summary(self) -> dict[str, Any]:
        """One line of the log, JSON types."""
        told: dict[str, Any] = {"stamp": self.stamp, "state": self.state}
        if self.T_map_base is not None:
            pose = self.T_map_base
            told |= {
                "x": round(pose.x, 5),
                "y": round(pose.y, 5),
                "yaw_deg": round(float(np.degrees(pose.yaw)), 4),
                "position_sigma_m": round(self.position_sigma, 6),
                "yaw_sigma_deg": round(float(np.degrees(self.yaw_sigma)), 4),
            }
        told["cameras"] = list(self.cameras)
        told["rejected"] = {s.camera: s.why for s in self.sightings if s.reason is not None}
        if self.note is not None:
            told["note"] = self.note
        told["sightings"] = [sighting.summary() for sighting in self.sightings]
        return told
