"""How a cloud becomes a network's input; stored in the network's file."""

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

MAX_VIEWS = 64
MAX_POINTS = 1_000_000
"""Largest number of points of an object in a network's input."""
MAX_MARGIN = 4.0


class InputSpec(ABC):
    """Specification of a network's inputs."""

    kind: str
    """Identifies the kind of specification in files."""
    azimuth_views: int
    """Inputs per object, each turned by a further fraction of an azimuth cell; the classifier
    averages over them. Dithered grids also have sub-cell offsets and other sizes."""
    margin: float
    """Size of the cylinder of the input in units of the smallest one round the object."""

    @property
    @abstractmethod
    def input_shape(self) -> tuple[int, ...]:
        """Shape of one input, without the batch axis."""

    @property
    def takes_context(self) -> bool:
        """Whether the network takes a context beside each input, see `grid_context`."""
        return False

    @property
    def visibility(self) -> bool:
        """Whether inputs separate free from unobserved cells."""
        return False

    @property
    def metric(self) -> bool:
        """Whether the network takes the object's size in metres."""
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
        """The inputs for a cloud that is turned about the vertical by each of `yaws`.

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
    def all_bounds(self, bounds: Grid, max_views: int | None = None) -> list[Grid]:
        """The empty grids of all views of an object.

        Args:
            bounds: Of the first view.
            max_views: Upper bound of the number of views.

        Returns:
            `azimuth_views` grids, or `max_views`; the first is `bounds`.
        """

    @abstractmethod
    def with_views(self, azimuth_views: int, dithered: bool = False) -> InputSpec:
        """A copy with another number of inputs per object.

        Args:
            azimuth_views: Number of inputs.
            dithered: Whether the grids also have sub-cell offsets in height and other sizes;
                otherwise they are only turned.

        Raises:
            InputError: Fewer than one view, several views of something without azimuth cells, or
                impossible dithering.
        """

    def input_of(self, grid: OccupancyGrid) -> NDArray[np.uint8]:
        """(1, *shape) the input for a grid.

        Raises:
            InputError: The grid does not fit, see `accepts`.
        """
        self.accepts(grid)
        return grid.occupied[None].astype(np.uint8)

    @abstractmethod
    def with_margin(self, margin: float) -> InputSpec:
        """A copy with another margin.

        Raises:
            InputError: Out of range.
        """

    @abstractmethod
    def accepts(self, grid: OccupancyGrid) -> None:
        """Check that a grid fits the network's input.

        Raises:
            InputError: It does not; the message says what is expected.
        """

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The input specification as JSON types; `input_spec_from_dict` reads it."""


def cylinder_round(
    cloud: PointCloud, margin: float, shape: Sequence[int] = (32, 32, 32)
) -> CylindricalGrid:
    """The cylinder round an object.

    Args:
        cloud: (n, 3) points.
        margin: Size in units of the smallest cylinder about the area-weighted centre.
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


def require_margin(input_spec: InputSpec) -> None:
    """Check the margin, which may come from an untrusted file.

    Raises:
        InputError: It is not a number from 1 to `MAX_MARGIN`.
    """
    value = input_spec.margin
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not 1 <= value <= MAX_MARGIN
    ):
        raise InputError(f"margin must be a number from 1 to {MAX_MARGIN:g}, not {value!r:.40}")


def require_counts(input_spec: object, *names: str, max_count: int) -> None:
    """Check fields that count something, which may come from an untrusted file.

    Args:
        input_spec: Holds the fields.
        names: Of the fields.
        max_count: The largest count.

    Raises:
        InputError: One is not a whole number from 1 to `max_count`.
    """
    for name in names:
        value = getattr(input_spec, name)
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= max_count:
            raise InputError(
                f"{name} must be a whole number from 1 to {max_count}, not {value!r:.40}"
            )
