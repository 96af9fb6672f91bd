"""Where a robot went during a run: what its picture shows beside the result."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose, Trajectory


class PlannedView(Protocol):
    """A place that a planner chose to look from."""

    @property
    def T_map_base(self) -> PlanarPose:
        """Where the robot stands."""
        ...

    @property
    def looks_at_xy(self) -> tuple[float, float]:
        """The place on the surface that the camera faces [m], map frame."""
        ...

    @property
    def normal_xy(self) -> tuple[float, float] | None:
        """The surface's unit normal there; None where the planner knows none."""
        ...


@dataclass(frozen=True, eq=False)
class Journey:
    """A robot's way through a room; everything is in the map frame.

    Attributes:
        stamps: (n,) [s] of frames, ascending.
        driven_m: (n,) [m] what the robot had driven by then.
        odometry: The camera by odometry alone, beginning where the run's first pose is; None
            where the wheels said nothing.
        truth: Where the camera really was; None where nobody knows.
        views: What the planner chose and the robot reached, in order.
        missed: What it chose and the robot did not reach.
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
        """(k,) [m] driven at given times [s]; None where that is not known."""
        if len(self.stamps) == 0:
            return None
        return np.interp(stamps, self.stamps, self.driven_m)
