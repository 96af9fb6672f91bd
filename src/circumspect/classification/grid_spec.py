"""How a cloud becomes the grids that a network was trained on.

A flat top or side moves from one layer of cells to the next by a millimetre of noise, all of it at
once. The further grids of an object are turned by fractions of an azimuth cell. Dithered grids also
have sub-cell offsets in height and other sizes, spread evenly by an additive recurrence (Roberts,
"The unreasonable effectiveness of quasirandom sequences", 2018).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from math import ceil, isclose
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.context import grid_context
from circumspect.classification.input_spec import (
    MAX_POINTS,
    MAX_VIEWS,
    InputSpec,
    cylinder_round,
    require_counts,
    require_margin,
    turned,
)
from circumspect.errors import InputError
from circumspect.geometry import PointCloud, fill_surface
from circumspect.grid import (
    FREE,
    OCCUPIED,
    CylindricalGrid,
    Grid,
    OccupancyGrid,
    RectangularGrid,
    hits_batch,
    hits_views,
)
from circumspect.grid.grid_arguments import checked_shape

PLASTIC = 1.324717957244746
"""The real root of x³ = x + 1."""
MARGIN_TOLERANCE = 1e-12
"""A margin may be short by this."""
MAX_DITHER_CELLS = 2.0
"""Displacement of the outermost border between the smallest and the largest grid [cells]; half way
to the axis it is half as large."""


@dataclass(frozen=True)
class GridSpec(InputSpec):
    """An occupancy grid as the input of a network.

    Attributes:
        kind: "cylindrical" or "rectangular".
        shape: Cells along (radius, azimuth, height), or (x, y, z).
        azimuth_views: Grids an object, each turned by a further fraction of an azimuth cell;
            the classifier averages over them.
        dithered: Further grids also have sub-cell offsets in height and other sizes, see `dither`.
        fill_below: Clouds of fewer points have holes at this resolution; their surface is
            filled between near neighbours.
        fill_samples: Points added to fill a surface.
        margin: The grid is this many times as large as the smallest one that holds the object.
        visibility: Inputs are the three states of each cell, which separate unobserved from empty
            space; otherwise they are 1 where occupied.
        metric: The network also takes the object's size in metres, or that it is unknown.
        scale_required: The network was never trained without the size: objects of unknown scale are
            refused.

    Raises:
        InputError: Another kind, an invalid shape, numbers out of range, or dithered grids without
            room for the object.
    """

    kind: str = "cylindrical"
    shape: tuple[int, int, int] = (32, 32, 32)
    azimuth_views: int = 1
    fill_below: int = 20_000
    fill_samples: int = 16_384
    margin: float = 1.0
    dithered: bool = False
    visibility: bool = False  # pyright: ignore[reportIncompatibleMethodOverride]
    metric: bool = False  # pyright: ignore[reportIncompatibleMethodOverride]
    scale_required: bool = False

    def __post_init__(self) -> None:
        if self.kind not in ("cylindrical", "rectangular"):
            raise InputError(f"a grid is cylindrical or rectangular, not {self.kind!r}")
        object.__setattr__(self, "shape", checked_shape(self.shape))
        require_counts(self, "azimuth_views", max_count=MAX_VIEWS)
        require_counts(self, "fill_below", "fill_samples", max_count=MAX_POINTS)
        require_margin(self)
        for name in ("dithered", "visibility", "metric", "scale_required"):
            if not isinstance(value := getattr(self, name), bool):
                raise InputError(f"{name} must be true or false, not {value!r:.40}")
        if self.takes_context:
            self._require_cylindrical()
        if self.dithered:
            self._require_cylindrical()
            require_room(self.shape, self.margin)

    def to_dict(self) -> dict[str, Any]:
        """See `InputSpec.to_dict`."""
        return {**asdict(self), "shape": list(self.shape)}

    @property
    def input_shape(self) -> tuple[int, ...]:
        """See `InputSpec.input_shape`."""
        return (1, *self.shape)

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
        """See `InputSpec.bounds`."""
        cylinder = cylinder_round(cloud, self.margin, self.shape)
        if self.kind == "cylindrical":
            return cylinder
        # The cube round the cylinder: it holds the object at every yaw.
        return RectangularGrid(self.shape, cylinder.radius, cylinder.centre_xyz)

    def all_bounds(self, bounds: Grid, max_views: int | None = None) -> list[Grid]:
        """See `InputSpec.all_bounds`."""
        count = self.azimuth_views if max_views is None else min(self.azimuth_views, max_views)
        if not isinstance(bounds, CylindricalGrid):
            return [bounds] * count
        # Cells that turn clockwise show what a cloud shows that turns counter-clockwise.
        further = [bounds.rotated(-view / count) for view in range(count)]
        if self.dithered:
            further = [dither(grid, view) for view, grid in enumerate(further)]
        return list(further)

    def grids(self, cloud: PointCloud, yaws: Sequence[float] = (0.0,)) -> NDArray[np.uint8]:
        """Grid a cloud, turned about the vertical by each of `yaws`.

        The points themselves are turned and gridded again for each angle, so an angle may be any
        fraction of a cell.

        Args:
            cloud: (n, 3) points of the object.
            yaws: y angles [rad], counter-clockwise seen from above.

        Returns:
            (y, azimuth_views, *shape) uint8, 1 where occupied.

        Raises:
            GeometryError: The points span no shape.
        """
        frame = self.bounds(cloud)
        points = self.surface(cloud).points_xyz
        occupied = np.empty((len(yaws), self.azimuth_views, *self.shape), np.uint8)
        if isinstance(frame, CylindricalGrid):
            views = self.all_bounds(frame)
            for grids, yaw in zip(occupied, yaws, strict=True):
                grids[:] = hits_views(views, points, yaw) == OCCUPIED
            return occupied
        points = points - np.asarray(frame.centre_xyz)
        views = self.all_bounds(frame.recentred())
        for grids, yaw in zip(occupied, yaws, strict=True):
            grids[:] = hits_batch(views, [turned(points, yaw)] * len(views))
        return occupied

    def inputs(self, cloud: PointCloud, yaws: Sequence[float] = (0.0,)) -> NDArray[np.uint8]:
        """See `InputSpec.inputs`; empty cells are `UNKNOWN`, since a cloud has no rays."""
        occupied = self.grids(cloud, yaws)[:, :, None]
        return occupied * np.uint8(OCCUPIED) if self.visibility else occupied

    def input_of(self, grid: OccupancyGrid) -> NDArray[np.uint8]:
        """See `InputSpec.input_of`; the states where visibility is shown."""
        occupied = super().input_of(grid)
        return grid.states[None] if self.visibility else occupied

    @property
    def takes_context(self) -> bool:
        """See `InputSpec.takes_context`."""
        return self.visibility or self.metric

    def context(
        self, inputs: NDArray[Any], bounds: Grid | None = None
    ) -> NDArray[np.float32] | None:
        """See `InputSpec.context`; visibility is known where a cell is `FREE`."""
        if not self.takes_context:
            return None
        first = inputs[0, 0]
        size = None
        if self.metric and isinstance(bounds, CylindricalGrid):
            size = bounds.radius, bounds.half_height
        if self.scale_required and size is None:
            raise InputError(
                "the classifier needs the object's size, not an unknown scale; state the unit of "
                "its points"
            )
        return grid_context(
            first == (OCCUPIED if self.visibility else 1), size,
            visible=self.visibility and bool((inputs == FREE).any()),
        )  # fmt: skip

    def with_views(self, azimuth_views: int, dithered: bool = False) -> GridSpec:
        """See `InputSpec.with_views`; a rectangular grid has one view."""
        if azimuth_views > 1:
            self._require_cylindrical()
        return replace(self, azimuth_views=azimuth_views, dithered=dithered)

    def _require_cylindrical(self) -> None:
        if self.kind != "cylindrical":
            raise InputError(
                "a rectangular grid has no azimuth cells to turn by fractions of; leave out "
                "--azimuth-views and --dithered"
            )

    def with_margin(self, margin: float) -> GridSpec:
        """See `InputSpec.with_margin`."""
        return replace(self, margin=margin)

    def accepts(self, grid: OccupancyGrid) -> None:
        """See `InputSpec.accepts`: of this kind and shape, as high as wide, and not empty."""
        kind = "cylindrical" if isinstance(grid.grid, CylindricalGrid) else "rectangular"
        if (kind, tuple(grid.grid.shape)) != (self.kind, self.shape):
            raise InputError(
                f"the grid is {kind} {tuple(grid.grid.shape)}, the classifier expects "
                f"{self.kind} {self.shape}; grid the cloud again"
            )
        bounds = grid.grid
        if isinstance(bounds, CylindricalGrid) and not isclose(bounds.half_height, bounds.radius):
            raise InputError(
                f"the grid is {bounds.half_height / bounds.radius:.3g} times as high as wide; make "
                "it by classifier.input_spec.bounds(cloud), which keeps proportions"
            )
        if not grid.occupied.any():
            raise InputError("the grid is empty; there is nothing to name")


def require_room(shape: Sequence[int], margin: float) -> None:
    """Check that every dithered grid holds the whole object.

    Args:
        shape: Cells along (radius, azimuth, height).
        margin: Size of the first grid in units of the smallest one.

    Raises:
        InputError: The margin is too small.
    """
    rings, _, layers = shape
    room = (1.0 - MAX_DITHER_CELLS / 2 / rings) * (1.0 - 1.0 / layers)
    if not room > 0:
        raise InputError("grids of one ring or one layer can not be dithered")
    if not margin * room >= 1.0 - MARGIN_TOLERANCE:
        raise InputError(
            f"dithered grids of these cells need a margin of {ceil(1e3 / room) / 1e3:g}, not "
            f"{margin:g}, to hold the whole object; circumspect export without --dithered makes "
            "a classifier that needs none"
        )


def dither(grid: CylindricalGrid, view: int) -> CylindricalGrid:
    """Dither one of an object's grids.

    Args:
        grid: The grid of view 0, or that turned.
        view: Number of the view, from 0.

    Returns:
        The grid, moved by up to half a cell along the axis and of another size.
    """
    up, wider = ((view / PLASTIC**power + 0.5) % 1.0 - 0.5 for power in (1, 2))
    rings, _, layers = grid.shape
    size = 1.0 + MAX_DITHER_CELLS * wider / rings
    x, y, z = grid.centre_xyz
    half_height = size * grid.half_height
    return replace(
        grid,
        radius=size * grid.radius,
        half_height=half_height,
        centre_xyz=(x, y, z + up * 2.0 * half_height / layers),
    )
