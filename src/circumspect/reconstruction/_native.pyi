"""Types of the C++ kernels in native/ that reconstruction uses."""

import numpy as np
from numpy.typing import NDArray

def frame_surface(
    depth: NDArray[np.float32],
    mask: NDArray[np.bool_],
    camera: tuple[float, float, float, float],
    pose: NDArray[np.float64],
    noise: tuple[float, float, float, float],
    point_block: int,
    normal_block: int,
    jump: float,
    min_incidence_cosine: float,
) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]: ...
def surface_sums(
    points_xyz: NDArray[np.float64],
    normals_xyz: NDArray[np.float32],
    weights: NDArray[np.float32],
    keys: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]: ...
def surface_means(
    totals: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def merge_rays(
    keys: NDArray[np.int64],
    origins_xyz: NDArray[np.float32],
    ends_xyz: NDArray[np.float32],
    on_object: NDArray[np.bool_],
    more_keys: NDArray[np.int64],
    more_origins_xyz: NDArray[np.float32],
    more_ends_xyz: NDArray[np.float32],
    more_on_object: NDArray[np.bool_],
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]: ...
def added_keys(known: NDArray[np.int64], keys: NDArray[np.int64]) -> NDArray[np.int64] | None: ...
