"""Types of the C++ kernels in native/ that sensing uses."""

import numpy as np
from numpy.typing import NDArray

def block_means(
    depth: NDArray[np.float32],
    mask: NDArray[np.bool_] | None,
    block: int,
    jump: float,
    mean: NDArray[np.float32],
    counts: NDArray[np.int32],
) -> None: ...
def continuous(
    depth: NDArray[np.float32],
    noise: tuple[float, float, float, float],
    spreads: float,
    slope: float,
    out: NDArray[np.bool_],
) -> None: ...
def keep_above(
    depth: NDArray[np.float32],
    up: tuple[float, float, float, float],
    camera: tuple[float, float, float, float],
    noise: tuple[float, float, float, float],
    margin: float,
    sigmas: float,
    farthest: float,
    mask: NDArray[np.bool_],
) -> None: ...
def plan_cells(
    depth: NDArray[np.float32],
    mask: NDArray[np.bool_],
    camera: tuple[float, float, float, float],
    pose: NDArray[np.float64],
    cell: float,
    block: int = 1,
) -> tuple[NDArray[np.int32], NDArray[np.int64], float, float, int, int]: ...
def keep_cells(
    cell: NDArray[np.int32],
    wanted: NDArray[np.bool_],
    mask: NDArray[np.bool_],
    block: int = 1,
) -> None: ...
