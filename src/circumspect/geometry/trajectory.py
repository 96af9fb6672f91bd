"""Where something was, and when."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry.frozen_array import ReadOnlyArrays, frozen
from circumspect.geometry.given_transform import require_transform

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform


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
        """(n, 3) [m]: the camera's places in map."""
        return self.T_map_camera.translation

    def moved(self, T_target_map: RigidTransform) -> Trajectory:
        """The same trajectory in another frame.

        Raises:
            InputError: It is no RigidTransform.
        """
        T_target_map = require_transform(T_target_map, "T_target_map")
        return Trajectory(self.stamps, T_target_map * self.T_map_camera)
