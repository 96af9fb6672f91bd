"""What lies between a cloud and a network's input; it travels in the network's file."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PointCloud, require_extent
from circumspect.grid import CylindricalGrid, Grid, OccupancyGrid, RectangularGrid

MOST_VIEWS = 64
MOST_POINTS = 1_000_000
"""Of an object, as it is shown to a network."""
MOST_MARGIN = 4.0


class InputRecipe(ABC):
    """How an object is shown to a network."""

    kind: str
    """Tells recipes apart in files."""
    azimuth_views: int
    """Inputs an object, each turned by a further fraction of an azimuth cell, and of grids that are
    staggered also elsewhere and of another size; the classifier averages over them."""
    margin: float
    """Networks see the object in a cylinder this many times as large as the one round it."""

    @property
    @abstractmethod
    def input_shape(self) -> tuple[int, ...]:
        """Of one input, without the axis of the batch."""

    @property
    def takes_context(self) -> bool:
        """Whether a network is shown a context beside each input, see `grid_context`."""
        return False

    @property
    def visibility(self) -> bool:
        """Whether it is shown which cells are free and which were never seen."""
        return False

    @property
    def metric(self) -> bool:
        """Whether it is shown the object's size in metres."""
        return False

    def context(
        self,
        inputs: NDArray[Any],  # noqa: ARG002
        bounds: Grid | None = None,  # noqa: ARG002
    ) -> NDArray[np.float32] | None:
        """The context of one object.

        Args:
            inputs: (views, *input_shape).
            bounds: Of the first view in metres; None where the object's scale is unknown.

        Returns:
            (6,), or None where the network takes none.
        """
        return None

    @abstractmethod
    def inputs(self, cloud: PointCloud, yaws: Sequence[float] = (0.0,)) -> NDArray[Any]:
        """What the network sees of a cloud that is turned about the vertical by each of `yaws`.

        Args:
            cloud: (n, 3) points of the object.
            yaws: y angles [rad], counter-clockwise seen from above.

        Returns:
            (y, azimuth_views, *input_shape).

        Raises:
            GeometryError: The points span no shape.
        """

    @abstractmethod
    def bounds(self, cloud: PointCloud) -> CylindricalGrid | RectangularGrid:
        """The empty grid around a cloud: axis through its area-weighted centre, isotropic.

        Raises:
            GeometryError: The points span no shape.
        """

    @abstractmethod
    def all_bounds(self, bounds: Grid, most: int | None = None) -> list[Grid]:
        """The empty grids of all views of an object.

        Args:
            bounds: Of the first view.
            most: As if `azimuth_views` were no more than this.

        Returns:
            `azimuth_views` grids, or `most`, of which the first is `bounds`.
        """

    @abstractmethod
    def with_views(self, azimuth_views: int, staggered: bool = False) -> InputRecipe:
        """The same with other inputs of an object.

        Args:
            azimuth_views: How many.
            staggered: Whether their cells also begin at other heights and are of other sizes;
                without, they are turned and no more.

        Raises:
            InputError: Fewer than one, more than one of what has no azimuth cells, or staggered
                ones that there can not be.
        """

    def input_of(self, grid: OccupancyGrid) -> NDArray[np.uint8]:
        """(1, *shape) the input that a grid is.

        Raises:
            InputError: It can not be shown, see `accepts`.
        """
        self.accepts(grid)
        return grid.occupied[None].astype(np.uint8)

    @abstractmethod
    def with_margin(self, margin: float) -> InputRecipe:
        """The same with another margin.

        Raises:
            InputError: Out of range.
        """

    @abstractmethod
    def accepts(self, grid: OccupancyGrid) -> None:
        """Check that a grid can be shown as it is.

        Raises:
            InputError: It can not; the message says what is expected.
        """

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The recipe as JSON types; `recipe_from_dict` reads it back."""


def cylinder_round(
    cloud: PointCloud, margin: float, shape: Sequence[int] = (32, 32, 32)
) -> CylindricalGrid:
    """The cylinder in which an object is seen.

    Args:
        cloud: (n, 3) points.
        margin: How many times as large as the smallest one about the area-weighted centre.
        shape: Cells along (radius, azimuth, height).

    Raises:
        GeometryError: The points span no shape.
    """
    require_extent(cloud)
    smallest = CylindricalGrid.fit(cloud, shape)
    return replace(
        smallest, radius=margin * smallest.radius, half_height=margin * smallest.half_height
    )


def turned(points_xyz: NDArray[np.float64], yaw: float) -> NDArray[np.float64]:
    """Points turned about the z axis.

    Args:
        points_xyz: (n, 3).
        yaw: [rad], counter-clockwise seen from above.
    """
    if yaw == 0.0:
        return points_xyz
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return points_xyz @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def require_margin(recipe: InputRecipe) -> None:
    """Check the margin; it may come from a stranger's file.

    Raises:
        InputError: It is not a number from 1 to `MOST_MARGIN`.
    """
    value = recipe.margin
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not 1 <= value <= MOST_MARGIN
    ):
        raise InputError(f"margin must be a number from 1 to {MOST_MARGIN:g}, not {value!r:.40}")


def require_counts(recipe: object, *names: str, most: int) -> None:
    """Check fields that count something; they may come from a stranger's file.

    Args:
        recipe: Whose fields.
        names: Of the fields.
        most: The largest count.

    Raises:
        InputError: One is not a whole number from 1 to `most`.
    """
    for name in names:
        value = getattr(recipe, name)
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
            raise InputError(f"{name} must be a whole number from 1 to {most}, not {value!r:.40}")
