"""Types of the C++ kernels in native/ that geometry uses."""

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
