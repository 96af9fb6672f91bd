"""Poses over time, complete or logged during a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry.frozen_array import ReadOnlyArrays, frozen
from circumspect.geometry.given_shapes import require_transform
from circumspect.geometry.growing_table import GrowingTable

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform


class TrajectoryLog:
    """A log of poses in ascending order; poses that are not later than all before are left out."""

    def __init__(self) -> None:
        """Create an empty log."""
        self._stamps = GrowingTable(1)
        self._matrices = GrowingTable(16)
        self._last = float("-inf")

    def __len__(self) -> int:
        return len(self._stamps)

    def is_later(self, stamp: float) -> bool:
        """Whether a time is later than all before."""
        return stamp > self._last

    def add(self, stamp: float, T_map_camera: RigidTransform) -> None:
        """Log one pose.

        Args:
            stamp: Its time [s].
            T_map_camera: A single pose.
        """
        if self.is_later(stamp):
            self._last = stamp
            self._stamps.append(stamp)
            self._matrices.append(T_map_camera.as_matrix())

    @property
    def trajectory(self) -> Trajectory | None:
        """All poses so far, bit-identical; None if there are none."""
        if not len(self):
            return None
        from scipy.spatial.transform import RigidTransform

        matrices = self._matrices.rows.reshape(-1, 4, 4)
        return Trajectory(self._stamps.rows[:, 0], RigidTransform(matrices, normalize=False))


@dataclass(frozen=True, eq=False)
class Trajectory(ReadOnlyArrays):
    """Poses of a camera over time.

    Attributes:
        stamps: (n,) float64 [s], strictly increasing, read-only.
        T_map_camera: n poses: camera (optical frame) in map.

    Raises:
        GeometryError: Stamps that are not finite or do not increase, or not one for each pose.
        InputError: The poses are no RigidTransform.
    """

    stamps: NDArray[np.float64]
    T_map_camera: RigidTransform

    def __post_init__(self) -> None:
        stamps = frozen(self.stamps)
        if stamps.ndim != 1:
            raise GeometryError(f"stamps must have shape (n,), not {stamps.shape}")
        if not np.isfinite(stamps).all():
            raise GeometryError("stamps hold NaN or infinite values")
        late = np.flatnonzero(np.diff(stamps) <= 0)
        if len(late):
            at = int(late[0]) + 1
            raise GeometryError(
                f"stamps must increase strictly: number {at} is {stamps[at]:.9g} s after "
                f"{stamps[at - 1]:.9g} s"
            )
        T_map_camera = require_transform(self.T_map_camera, "T_map_camera")
        if T_map_camera.single or len(T_map_camera) != len(stamps):
            poses = 1 if T_map_camera.single else len(T_map_camera)
            raise GeometryError(f"{len(stamps)} stamps need as many poses in a batch, not {poses}")
        object.__setattr__(self, "stamps", stamps)

    def __len__(self) -> int:
        return len(self.stamps)

    @property
    def positions_xyz(self) -> NDArray[np.float64]:
        """(n, 3) [m]: the camera's positions in map."""
        return self.T_map_camera.translation

    def moved(self, T_target_map: RigidTransform) -> Trajectory:
        """The same trajectory in another frame.

        Raises:
            InputError: It is no RigidTransform.
        """
        T_target_map = require_transform(T_target_map, "T_target_map")
        return Trajectory(self.stamps, T_target_map * self.T_map_camera)
