"""The path of a robot in a run, as its picture shows it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose, Trajectory


class PlannedView(Protocol):
    """A view that a planner chose."""

    @property
    def T_map_base(self) -> PlanarPose:
        """Pose of the robot."""
        ...

    @property
    def looks_at_xy(self) -> tuple[float, float]:
        """The point on the surface that the camera faces [m], map frame."""
        ...

    @property
    def normal_xy(self) -> tuple[float, float] | None:
        """The surface's unit normal there; None if the planner used none."""
        ...


@dataclass(frozen=True, eq=False)
class RunPath:
    """The path of a robot through a room, map frame.

    Attributes:
        stamps: (n,) [s] of frames, ascending.
        driven_m: (n,) [m] the distance driven by then.
        odometry: The camera by odometry alone, from the run's first pose on; None without
            odometry.
        truth: The true path of the camera; None if it is unknown.
        views: The views that the robot reached, in order.
        missed: The views that it did not reach.
        walls_xy: Outlines of walls and clutter, each (k, 2) [m].
    """

    stamps: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    driven_m: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    odometry: Trajectory | None = None
    truth: Trajectory | None = None
    views: tuple[PlannedView, ...] = ()
    missed: tuple[PlannedView, ...] = ()
    walls_xy: tuple[NDArray[np.float64], ...] = ()

    def driven_by(self, stamps: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """(k,) [m] distances driven at given times [s]; None if they are unknown."""
        if len(self.stamps) == 0:
            return None
        return np.interp(stamps, self.stamps, self.driven_m)
