"""The cylindrical grid of the paper."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

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

RADIUS_AXIS, AZIMUTH_AXIS, HEIGHT_AXIS = 0, 1, 2
"""Axes of an array of cells: (radius, azimuth, height)."""


@dataclass(frozen=True)
class CylindricalGrid(Grid):
    """A cylinder about a vertical axis in rings, sectors and layers (section 3.2).

    A turn of the object by whole azimuth cells rolls its occupancy along `AZIMUTH_AXIS`.

    Attributes:
        shape: Cells along (radius, azimuth, height).
        radius: [m]; cells span r from 0 to it.
        half_height: [m]; cells span the height from -half_height to half_height about the centre.
        centre_xyz: (3,) [m] the middle of the axis.
        azimuth_offset: [rad] where the first sector begins, counter-clockwise from +x seen from
            above; kept within [0, 2π).

    Raises:
        InputError: Lengths not positive, values not finite, too many cells.
    """

    bounds_names = ("radius", "half_height", "azimuth_offset")

    shape: tuple[int, int, int] = (32, 32, 32)
    radius: float = 1.0
    half_height: float = 1.0
    centre_xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    azimuth_offset: float = 0.0

    def __post_init__(self) -> None:
        turn = checked_number(self.azimuth_offset, "azimuth_offset") % math.tau
        for name, value in (
            ("shape", checked_shape(self.shape)),
            ("radius", checked_length(self.radius, "radius")),
            ("half_height", checked_length(self.half_height, "half_height")),
            ("centre_xyz", checked_centre(self.centre_xyz)),
            ("azimuth_offset", turn if turn < math.tau else 0.0),
        ):
            object.__setattr__(self, name, value)

    @classmethod
    def fit(
        cls,
        cloud: PointCloud | ArrayLike,
        shape: Sequence[int] = (32, 32, 32),
        half_height_per_radius: float = 1.0,
        azimuth_offset: float = 0.0,
    ) -> Self:
        """The smallest cylinder about the area-weighted centre that holds all points.

        Args:
            cloud: (n, 3) points of the object [m], z up.
            shape: Cells along (radius, azimuth, height).
            half_height_per_radius: Proportion of the cylinder; the scale is isotropic.
            azimuth_offset: [rad] where the first sector begins.

        Raises:
            GeometryError: All points coincide, or lie too far out for the arithmetic.
            InputError: A mesh or a path in the place of points, wrong shape or proportion.
        """
        proportion = checked_length(half_height_per_radius, "half_height_per_radius")
        cloud = as_cloud(cloud)
        reach = reach_of(cloud)
        height = reach.along_xyz[2]
        radius = max(reach.radius, height / proportion)
        require_size(cloud, reach, radius)
        # A product may be rounded below the height.
        half_height = max(height, radius * proportion)
        return cls(checked_shape(shape), radius, half_height, reach.centre_xyz, azimuth_offset)

    def kernels(self) -> _native.Cylinder:
        """See `Grid.kernels`."""
        return _native.Cylinder(
            self.shape, self.radius, self.half_height, self.centre_xyz, self.azimuth_offset
        )

    def recentred(self, centre_xyz: ArrayLike = (0.0, 0.0, 0.0)) -> Self:
        """See `Grid.recentred`."""
        return replace(self, centre_xyz=checked_centre(centre_xyz))

    def scaled(self, factor: float) -> Self:
        """See `Grid.scaled`."""
        return replace(
            self,
            radius=factor * self.radius,
            half_height=factor * self.half_height,
            centre_xyz=checked_centre(factor * np.asarray(self.centre_xyz)),
        )

    def outermost(self, cells: OccupancyGrid) -> NDArray[np.float64]:
        """(azimuth, height) radius of the outermost occupied cell [m], NaN where there is none."""
        occupied, rings = cells.occupied, self.shape[RADIUS_AXIS]
        radii = (rings - occupied[::-1].argmax(axis=RADIUS_AXIS)) * (self.radius / rings)
        return np.where(occupied.any(axis=RADIUS_AXIS), radii, np.nan)

    def draw(self, axes: Axes, cells: OccupancyGrid, unit: str = "m") -> None:
        """Unrolled: outermost occupied radius over azimuth and height."""
        from circumspect.grid.grid_plot import draw_unrolled

        first, middle = math.degrees(self.azimuth_offset), self.centre_xyz[2]
        extent = first, first + 360.0, middle - self.half_height, middle + self.half_height
        known = np.any(cells.occupied | cells.free, axis=RADIUS_AXIS)
        draw_unrolled(axes, self.outermost(cells), known, extent, self.radius, unit)

    def rotated(self, k_cells: float) -> Self:
        """The grid turned counter-clockwise by azimuth cells, whole or fractions.

        Occupancy of the same points is rolled by `-k_cells` along `AZIMUTH_AXIS`.

        Raises:
            InputError: `k_cells` is not finite.
        """
        turn = checked_number(k_cells, "k_cells") * math.tau / self.shape[AZIMUTH_AXIS]
        return replace(self, azimuth_offset=self.azimuth_offset + turn)
