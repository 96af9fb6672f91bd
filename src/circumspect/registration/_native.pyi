"""Types of the C++ kernels in native/ that registration uses."""

import numpy as np
from numpy.typing import NDArray

class PlaneMap:
    def __init__(
        self,
        points_xyz: NDArray[np.float64],
        normals_xyz: NDArray[np.float64],
        sigmas: NDArray[np.float64],
        normal_variances: NDArray[np.float64],
        roughness: NDArray[np.float64],
        cell: float,
    ) -> None: ...
    def nearest(
        self,
        points_xyz: NDArray[np.float64],
        camera_xyz: NDArray[np.float64],
        max_distance: float,
        max_backface_cosine: float,
    ) -> NDArray[np.int64]: ...
    def linearised(
        self,
        points_xyz: NDArray[np.float64],
        sigmas: NDArray[np.float64],
        correlations: NDArray[np.float64],
        pose: NDArray[np.float64],
        *,
        max_distance: float,
        tukey_cutoff: float,
        correlation_factor: float,
        min_noise_scale: float,
        roughness_factor: float,
        min_cutoff: float,
        max_floor_height: float,
        max_plane_distance: float,
        max_backface_cosine: float,
        min_points_off_floor: int,
        min_correspondences: int,
    ) -> tuple[
        NDArray[np.float64],
        NDArray[np.float64],
        NDArray[np.float64],
        int,
        float,
        float,
        float,
        float,
    ]: ...

def plane_fits(
    points_xyz: NDArray[np.float64], neighbours: NDArray[np.int64], threads: int = 1
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
