"""Types of the C++ kernels in native/ that mapping uses."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

class PlaneMap:
    def __init__(
        self,
        points_xyz: NDArray[np.float64],
        normals_xyz: NDArray[np.float64],
        sigmas: NDArray[np.float64],
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
        floor: float,
        far: float,
        standing: int,
        fewest: int,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], int, float, float, float, float]: ...

def groups(
    keys: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]: ...
def row_sums(
    keys: NDArray[np.int64], values: NDArray[Any]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]: ...
def table_sum(
    one_keys: NDArray[np.int64],
    one: NDArray[np.float64],
    other_keys: NDArray[np.int64],
    other: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]: ...
