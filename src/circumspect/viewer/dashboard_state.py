"""The contents of the dashboard at one moment of a run, live or played back."""

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
class ObjectSnapshot:
    """The object model and its grid.

    Attributes:
        points_xyz: (n, 3) [m] map frame.
        normals_xyz: (n, 3) unit normals.
        frames_seen: (n,) number of frames that observed each point.
        grid: The occupancy grid; None before the first.
    """

    points_xyz: NDArray[np.floating] = field(default_factory=lambda: NOTHING)
    normals_xyz: NDArray[np.floating] = field(default_factory=lambda: NOTHING)
    frames_seen: NDArray[np.integer] = field(default_factory=lambda: np.empty(0, np.int64))
    grid: OccupancyGrid | None = None


@dataclass(frozen=True, eq=False)
class FrameImages:
    """The images of a frame.

    Attributes:
        depth: (height, width) [m], NaN where missing; may be thinned.
        colour: (height, width, 3) uint8 RGB, or None.
        frame: Number of the frame.
    """

    depth: NDArray[np.floating]
    colour: NDArray[np.uint8] | None
    frame: int


@dataclass(frozen=True, eq=False)
class DashboardState:
    """The contents of the dashboard at one moment.

    Attributes:
        rows: Summaries of the frames, see `RecognitionStep.summary`. The list may grow after this
            moment; only the first `count` rows belong to it.
        count: Number of frames so far, including this moment's.
        object_snapshot: The object model and its grid.
        images: Images of the latest frame; None if not stored.
        camera: Intrinsics of the camera; None if unknown.
        T_map_camera: Estimated pose of the camera; None if unknown.
        T_base_camera: Mount of the camera; None if unknown.
        path_xyz: (p, 3) [m] path of the camera by registration.
        odometry_xyz: (q, 3) [m] path of the camera by odometry alone.
        target: The next view of the robot.
        surroundings: Walls and clutter, the same instance throughout a run; None if unknown.
        truth: True class of the object; None if unknown.
        message: A line about the whole run, such as its end reason or missing files.
        run: Identity of the run; the same instance throughout a run.
        extent_xyz: (2, 3) [m] lowest and highest coordinates of the whole object; None if unknown.
    """

    rows: Sequence[Mapping[str, Any]]
    count: int
    object_snapshot: ObjectSnapshot = field(default_factory=ObjectSnapshot)
    images: FrameImages | None = None
    camera: PinholeCamera | None = None
    T_map_camera: RigidTransform | None = None
    T_base_camera: RigidTransform | None = None
    path_xyz: NDArray[np.floating] = field(default_factory=lambda: NOTHING)
    odometry_xyz: NDArray[np.floating] = field(default_factory=lambda: NOTHING)
    target: PlannedView | None = None
    surroundings: Surroundings | None = None
    truth: str | None = None
    message: str = ""
    run: object = None
    extent_xyz: NDArray[np.floating] | None = None

    @property
    def row(self) -> Mapping[str, Any]:
        """The row of this moment's frame; empty before the first frame."""
        return self.rows[self.count - 1] if self.count else {}
