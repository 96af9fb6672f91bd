"""Types of the C++ kernels in native/."""

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

MOST_CELLS_ALONG: int
MOST_CELLS: int

_Axes = tuple[float, float, float]

class _Kernels:
    def hits(
        self, points_xyz: NDArray[Any], states: NDArray[Any], value: int, threads: int
    ) -> int: ...
    def indices(self, points_xyz: NDArray[Any], out: NDArray[Any], threads: int) -> int: ...
    def passed(
        self,
        origins_xyz: NDArray[Any],
        ends_xyz: NDArray[Any],
        states: NDArray[Any],
        value: int,
        threads: int,
    ) -> int: ...

class Cylinder(_Kernels):
    def __init__(
        self,
        shape: tuple[int, int, int],
        radius: float,
        half_height: float,
        centre_xyz: tuple[float, float, float],
        azimuth_offset: float,
    ) -> None: ...

class Box(_Kernels):
    def __init__(
        self,
        shape: tuple[int, int, int],
        half_width: float,
        centre_xyz: tuple[float, float, float],
        yaw: float,
    ) -> None: ...

def hits_batch(
    grids: Sequence[Cylinder] | Sequence[Box],
    clouds: Sequence[NDArray[Any]],
    states: NDArray[Any],
    value: int,
    threads: int,
) -> int: ...
def hits_coaxial(
    grids: Sequence[Cylinder],
    points_xyz: NDArray[Any],
    yaw: float,
    states: NDArray[Any],
    value: int,
    threads: int,
) -> int: ...
def passed_coaxial(
    grids: Sequence[Cylinder],
    origins_xyz: NDArray[Any],
    ends_xyz: NDArray[Any],
    states: NDArray[Any],
    value: int,
    threads: int,
) -> int: ...
def weighted_centre(
    points_xyz: NDArray[Any], weights: NDArray[Any] | None
) -> tuple[_Axes, _Axes, _Axes]: ...
def reach(
    points_xyz: NDArray[Any], centre_xyz: _Axes, yaw: float
) -> tuple[float, float, float, float]: ...
