"""What the dashboard shows at one moment of a run, live or played back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera
from circumspect.grid import OccupancyGrid
from circumspect.runs.run_path import PlannedView
from circumspect.runs.surroundings import Surroundings

NOTHING = np.empty((0, 3), np.float32)


@dataclass(frozen=True, eq=False)
class ShownObject:
    """The object as far as it is known.

    Attributes:
        points_xyz: (n, 3) [m] map frame.
        normals_xyz: (n, 3) unit normals.
        frames_seen: (n,) how many frames showed each point.
        grid: Its occupancy grid; None before there is one.
    """

    points_xyz: NDArray[np.floating] = field(default_factory=lambda: NOTHING)
    normals_xyz: NDArray[np.floating] = field(default_factory=lambda: NOTHING)
    frames_seen: NDArray[np.integer] = field(default_factory=lambda: np.empty(0, np.int64))
    grid: OccupancyGrid | None = None


@dataclass(frozen=True, eq=False)
class ShownImages:
    """What the camera saw.

    Attributes:
        depth: (height, width) [m], NaN where nothing was measured; may be thinned.
        colour: (height, width, 3) uint8 RGB, or None.
        frame: Number of the frame.
    """

    depth: NDArray[np.floating]
    colour: NDArray[np.uint8] | None
    frame: int


@dataclass(frozen=True, eq=False)
class Shown:
    """One moment.

    Attributes:
        rows: What the frames so far led to, as `RecognitionStep.summary` tells it; the last one
            is this moment's. Never changed, but may grow at the end: take `count` of them.
        count: How many of the rows belong to this moment.
        thing: The object.
        images: The latest frame; None where none is kept.
        camera: The camera's intrinsics; None where not known.
        T_map_camera: Where it is believed to be; None where not known.
        T_base_camera: Where it is mounted; None where not known.
        path_xyz: (p, 3) [m] where the camera was, by registration.
        odometry_xyz: (q, 3) [m] the same by odometry alone.
        target: The view that the robot drives to.
        surroundings: What stands around; the same object through all of a run. None while nobody
            knows.
        truth: The object's true class, where that is known.
        news: A line about the run as a whole: how it ended, what is missing.
        run: Tells this run from another: the same object through all of it.
    """

    rows: Sequence[Mapping[str, Any]]
    count: int
    thing: ShownObject = field(default_factory=ShownObject)
    images: ShownImages | None = None
    camera: PinholeCamera | None = None
    T_map_camera: RigidTransform | None = None
    T_base_camera: RigidTransform | None = None
    path_xyz: NDArray[np.floating] = field(default_factory=lambda: NOTHING)
    odometry_xyz: NDArray[np.floating] = field(default_factory=lambda: NOTHING)
    target: PlannedView | None = None
    surroundings: Surroundings | None = None
    truth: str | None = None
    news: str = ""
    run: object = None

    @property
    def row(self) -> Mapping[str, Any]:
        """What this moment's frame led to; empty before the first."""
        return self.rows[self.count - 1] if self.count else {}
