"""Types of the C++ kernels in native/ that tracking uses."""

import numpy as np
from numpy.typing import NDArray

def linearised(
    poses: NDArray[np.floating],
    scale: NDArray[np.floating],
    prior_pose: NDArray[np.floating],
    prior_scale: NDArray[np.floating],
    prior_information: NDArray[np.floating],
    motions: NDArray[np.floating],
    by_scale: NDArray[np.floating],
    motion_information: NDArray[np.floating],
    measured: NDArray[np.floating],
    measured_information: NDArray[np.floating],
    mounts: NDArray[np.floating],
    level_information: NDArray[np.floating],
    kernel: float,
    count: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def solved(
    hessian: NDArray[np.floating], gradient: NDArray[np.floating], count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def moved(poses: NDArray[np.floating], changes: NDArray[np.floating]) -> NDArray[np.float64]: ...
