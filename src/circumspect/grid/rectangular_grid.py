"""The rectangular grid, the paper's baseline."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from circumspect.geometry import PointCloud
from circumspect.geometry.given_shapes import as_cloud
from circumspect.grid import _native
from circumspect.grid.bounds_fit import reach_of, require_size
from circumspect.grid.grid import Grid, OccupancyGrid
from circumspect.grid.grid_arguments import (
    checked_centre,
    checked_length,
    checked_number,
    checked_shape,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class RectangularGrid(Grid):
    """A cube in cells along its own x, y and z.

    Attributes:
        shape: Cells along (x, y, z).
        half_width: [m]; cells span -half_width to half_width about the centre on each axis.
        centre_xyz: (3,) [m] the middle of the cube.
        yaw: [rad] of the cube's x axis, counter-clockwise from +x seen from above.

    Raises:
        InputError: Lengths not positive, values not finite, too many cells.
    """

    bounds_names = ("half_width", "yaw")

    shape: tuple[int, int, int] = (32, 32, 32)
    half_width: float = 1.0
    centre_xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (
            ("shape", checked_shape(self.shape)),
            ("half_width", checked_length(self.half_width, "half_width")),
            ("centre_xyz", checked_centre(self.centre_xyz)),
            ("yaw", checked_number(self.yaw, "yaw")),
        ):
            object.__setattr__(self, name, value)

    @classmethod
    def fit(
        cls, cloud: PointCloud | ArrayLike, shape: Sequence[int] = (32, 32, 32), yaw: float = 0.0
    ) -> Self:
        """The smallest cube about the area-weighted centre that holds all points.

        Args:
            cloud: (n, 3) points of the object [m], z up.
            shape: Cells along (x, y, z).
            yaw: [rad] of the cube.

        Raises:
            GeometryError: All points coincide, or lie too far out for the arithmetic.
            InputError: A mesh or a path in the place of points, wrong shape or yaw.
        """
        angle = checked_number(yaw, "yaw")
        cloud = as_cloud(cloud)
        reach = reach_of(cloud, angle)
        half_width = max(reach.along_xyz)
        require_size(cloud, reach, half_width)
        return cls(checked_shape(shape), half_width, reach.centre_xyz, angle)

    def kernels(self) -> _native.Box:
        """See `Grid.kernels`."""
        return _native.Box(self.shape, self.half_width, self.centre_xyz, self.yaw)

    def recentred(self, centre_xyz: ArrayLike = (0.0, 0.0, 0.0)) -> Self:
        """See `Grid.recentred`."""
        return replace(self, centre_xyz=checked_centre(centre_xyz))

    def scaled(self, factor: float) -> Self:
        """See `Grid.scaled`."""
        return replace(
            self,
            half_width=factor * self.half_width,
            centre_xyz=checked_centre(factor * np.asarray(self.centre_xyz)),
        )

    def rotated(self, quarter_turns: int) -> Self:
        """The grid turned counter-clockwise by quarter turns."""
        turn = checked_number(quarter_turns, "quarter_turns") * (math.pi / 2)
        return replace(self, yaw=self.yaw + turn)

    def draw(self, axes: Axes, cells: OccupancyGrid, unit: str = "m") -> None:
        """From above: occupied cells over the height."""
        from circumspect.grid.grid_plot import draw_projection

        draw_projection(axes, cells.occupied, self.half_width, unit=unit)
