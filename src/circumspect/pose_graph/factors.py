"""Factors of a pose graph: measurements of poses `T_map_camera`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform


@dataclass(frozen=True, eq=False)
class BetweenFactor:
    """A relative measurement between two poses.

    Attributes:
        first: Index of one pose.
        second: Index of the other pose.
        T_first_second: The measurement.
        information: (6, 6) inverse covariance of the measurement, for changes of the second pose
            in its own frame [rad, m].
        robust: Whether the measurement may be an outlier. Such factors are weighted by Cauchy's
            kernel.
        transferred: Whether the measurement is that of a culled pose; see `transfer_factors`.
    """

    first: int
    second: int
    T_first_second: RigidTransform
    information: NDArray[np.floating]
    robust: bool = False
    transferred: bool = False


@dataclass(frozen=True, eq=False)
class LevelFactor:
    """A robot that stands level at z = 0, up to bumps.

    Attributes:
        pose: Index of the pose.
        T_base_camera: Mount of the camera.
        information: (3, 3) inverse covariance of roll [rad], pitch [rad] and height [m] of the
            base.
    """

    pose: int
    T_base_camera: RigidTransform
    information: NDArray[np.floating]
