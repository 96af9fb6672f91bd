"""Types of the C++ kernels in native/ that mapping uses."""

import numpy as np
from numpy.typing import NDArray

class PlaneMap:
    def __init__(
        self,
        points_xyz: NDArray[np.float64],
        normals_xyz: NDArray[np.float64],
        sigmas: NDArray[np.float64],
        slopes: NDArray[np.float64],
        unevenness: NDArray[np.float64],
        cell: float,
    ) -> None: ...
    def linearised(
        self,
        points_xyz: NDArray[np.float64],
        sigmas: NDArray[np.float64],
        pose: NDArray[np.float64],
        *,
        reach: float,
        tukey: float,
        correlation: float,
        least_spread: float,
        uneven: float,
        least_cut: float,
        floor: float,
        far: float,
        averted: float,
        standing: int,
        fewest: int,
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
    points_xyz: NDArray[np.float64], near: NDArray[np.int64], threads: int = 1
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
