"""Baseline tracker: scan-to-model registration by small_gicp alone."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import small_gicp
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.sensing import RgbdFrame

VOXEL = 0.03
"""Side of the voxels [m] of a scan and of the model."""
MAX_CORRESPONDENCE_M = 0.1
"""Maximum correspondence distance [m]."""
THREADS = 2
"""Number of threads, for a robot's computer with two cores."""
HORIZON = 1_000_000
"""Frames that an unobserved voxel is kept for: all of them, as in the package's map."""


@dataclass
class PlainGicp:
    """Voxelised GICP of each frame to a map of all frames before, as in small_gicp's example.

    The prediction is constant velocity. No registration is rejected, and no pose is corrected
    later.

    Attributes:
        max_depth: Maximum depth [m].
        threads: Number of threads.
    """

    max_depth: float
    threads: int = THREADS
    _model: small_gicp.GaussianVoxelMap = field(init=False)
    _last: NDArray[np.float64] | None = field(init=False, default=None)
    _step: NDArray[np.float64] = field(init=False, default_factory=lambda: np.eye(4))

    def __post_init__(self) -> None:
        self._model = small_gicp.GaussianVoxelMap(VOXEL)
        self._model.set_lru(horizon=HORIZON, clear_cycle=HORIZON)

    def track(
        self, frame: RgbdFrame, T_before_now: NDArray[np.float64] | None = None
    ) -> RigidTransform:
        """The pose of a frame; the first frame must have a pose.

        Args:
            frame: The next frame.
            T_before_now: (4, 4) predicted motion since the last frame; None means the last motion.
        """
        near = frame.valid & (frame.depth < self.max_depth)
        points_xyz = frame.camera.back_project(frame.depth, near)
        scan, _ = small_gicp.preprocess_points(points_xyz, VOXEL, num_threads=self.threads)
        if self._last is None:
            T_map_camera = frame.pose.as_matrix()
        else:
            guess = self._last @ (self._step if T_before_now is None else T_before_now)
            # small_gicp returns the identity for an empty scan.
            T_map_camera = guess if scan.size() == 0 else small_gicp.align(
                self._model, scan, guess,
                max_correspondence_distance=MAX_CORRESPONDENCE_M, num_threads=self.threads,
            ).T_target_source  # fmt: skip
            self._step = np.linalg.inv(self._last) @ T_map_camera
        self._model.insert(scan, T_map_camera)
        self._last = T_map_camera
        return RigidTransform.from_matrix(T_map_camera)
