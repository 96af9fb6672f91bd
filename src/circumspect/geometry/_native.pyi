"""Types of the C++ kernels in native/ that geometry uses."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

def extent(
    points_xyz: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
def face_normals(
    vertices_xyz: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]: ...
def short_edge_faces(
    points_xyz: NDArray[np.float64], neighbours: int, reach: float
) -> NDArray[np.int64]: ...
def spacing(points_xyz: NDArray[np.float64]) -> float: ...
def groups(
    keys: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]: ...
def group_sizes(keys: NDArray[np.int64]) -> NDArray[np.int64]: ...
def split_means(
    table_keys: NDArray[np.int64], totals: NDArray[np.float64], keys: NDArray[np.int64]
) -> NDArray[np.float64]: ...
def row_sums(
    keys: NDArray[np.int64], values: NDArray[Any]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]: ...
def packed_cells(
    points_xyz: NDArray[Any], side: float, bits: int, offset: int
) -> NDArray[np.int64]: ...
def patch_keys(cells: NDArray[np.int64], normals_xyz: NDArray[Any]) -> NDArray[np.int64]: ...
def table_sum(
    one_keys: NDArray[np.int64],
    one: NDArray[np.float64],
    other_keys: NDArray[np.int64],
    other: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]: ...
