"""How a cloud becomes the grids that a network was trained on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PointCloud, fill_surface, require_extent
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid, hits_batch
from circumspect.grid.grid_arguments import checked_shape


@dataclass(frozen=True)
class GridRecipe:
    """Everything between a cloud and a network's input; travels in the network's file.

    Attributes:
        kind: "cylindrical" or "rectangular".
        shape: Cells along (radius, azimuth, height), or (x, y, z).
        azimuth_views: Grids an object, each turned by a further fraction of an azimuth cell;
            the classifier averages over them.
        fill_below: Clouds of fewer points have holes at this resolution; their surface is
            filled between near neighbours.
        fill_samples: Points added to fill a surface.
    """

    kind: Literal["cylindrical", "rectangular"] = "cylindrical"
    shape: tuple[int, int, int] = (32, 32, 32)
    azimuth_views: int = 1
    fill_below: int = 20_000
    fill_samples: int = 16_384

    def __post_init__(self) -> None:
        if self.kind not in ("cylindrical", "rectangular"):
            raise InputError(f"a grid is cylindrical or rectangular, not {self.kind!r}")
        object.__setattr__(self, "shape", checked_shape(self.shape))
        for name in ("azimuth_views", "fill_below", "fill_samples"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise InputError(f"{name} must be a whole number of at least 1, not {value!r}")

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> GridRecipe:
        """Read back what `to_dict` made.

        Raises:
            InputError: Unknown or missing entries.
        """
        known = {f.name for f in fields(cls)}
        if unknown := set(document) - known:
            raise InputError(f"unknown grid settings {sorted(unknown)}; known: {sorted(known)}")
        return cls(**document)

    def to_dict(self) -> dict[str, Any]:
        """The recipe as JSON types."""
        return {**asdict(self), "shape": list(self.shape)}

    @property
    def unit_bounds(self) -> CylindricalGrid | RectangularGrid:
        """The grid of a normalised object: centre at the origin, scale 1."""
        if self.kind == "cylindrical":
            return CylindricalGrid(self.shape)
        return RectangularGrid(self.shape)

    def surface(self, cloud: PointCloud) -> PointCloud:
        """The cloud without holes at the grid's resolution.

        Args:
            cloud: (n, 3) points.

        Returns:
            The cloud itself where it is dense, else its points and those between neighbours.
        """
        if len(cloud) >= self.fill_below:
            return cloud
        return fill_surface(cloud, self.fill_samples)

    def bounds(self, cloud: PointCloud) -> CylindricalGrid | RectangularGrid:
        """The empty grid around a cloud: axis through its area-weighted centre, isotropic.

        Raises:
            GeometryError: The points span no shape.
        """
        require_extent(cloud)
        if self.kind == "cylindrical":
            return CylindricalGrid.fit(cloud, self.shape)
        return RectangularGrid.fit(cloud, self.shape)

    def grids(self, cloud: PointCloud, yaws: Sequence[float] = (0.0,)) -> NDArray[np.uint8]:
        """Grid a cloud, turned about the vertical by each of `yaws`.

        The points themselves are turned and gridded anew, so an angle may be any fraction of
        a cell.

        Args:
            cloud: (n, 3) points of the object.
            yaws: y angles [rad], counter-clockwise seen from above.

        Returns:
            (y, azimuth_views, *shape) uint8, 1 where occupied.

        Raises:
            GeometryError: The points span no shape.
        """
        frame = self.bounds(cloud)
        points = self.surface(cloud).points_xyz - np.asarray(frame.centre_xyz)
        centred = replace(frame, centre_xyz=(0.0, 0.0, 0.0))
        cell = 2 * np.pi / self.shape[1] if self.kind == "cylindrical" else 0.0
        turns = [
            yaw + cell * view / self.azimuth_views
            for yaw in yaws
            for view in range(self.azimuth_views)
        ]
        clouds = [_turned(points, turn) for turn in turns]
        occupied = hits_batch([centred] * len(clouds), clouds)
        return occupied.reshape(len(yaws), self.azimuth_views, *self.shape)

    def accepts(self, grid: OccupancyGrid) -> None:
        """Check that a grid is of this kind and shape.

        Raises:
            InputError: It is not; the message says what is expected.
        """
        kind = "cylindrical" if isinstance(grid.grid, CylindricalGrid) else "rectangular"
        if (kind, tuple(grid.grid.shape)) != (self.kind, self.shape):
            raise InputError(
                f"the grid is {kind} {tuple(grid.grid.shape)}, the classifier expects "
                f"{self.kind} {self.shape}; grid the cloud anew"
            )


def _turned(points_xyz: NDArray[np.float64], yaw: float) -> NDArray[np.float64]:
    if yaw == 0.0:
        return points_xyz
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return points_xyz @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
