"""How a cloud becomes a network's input points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

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
from circumspect.geometry.farthest_points import farthest_points
from circumspect.grid import CylindricalGrid, Grid, OccupancyGrid

MAX_SAMPLED = 16_384
"""Largest number of points in farthest-first order: the time grows with its square."""
Points = TypeVar("Points", NDArray[np.float32], NDArray[np.float64])


@dataclass(frozen=True)
class PointsSpec(InputSpec):
    """Points about the object's axis, in units of the radius of a cylinder round it.

    Attributes:
        count: Points per object.
        surface: Clouds of fewer points are filled between near neighbours; otherwise points are
            repeated.
        azimuth_views: Inputs per object, turned by fractions of a 32nd of a turn.
        kind: "points".
        margin: Size of the cylinder in units of the smallest one.
        farthest_first: The first half of the points is a farthest point sample of all of them, in
            the order of the sampling: every prefix is one as well. It begins with the point
            farthest from the middle. The other half is in no order.
    """

    count: int = 1024
    surface: bool = False
    azimuth_views: int = 1
    kind: str = "points"
    margin: float = 1.0
    farthest_first: bool = False

    def __post_init__(self) -> None:
        if self.kind != "points":
            raise InputError(f"points are of the kind 'points', not {self.kind!r}")
        if not isinstance(self.farthest_first, bool):
            raise InputError(
                f"farthest_first must be true or false, not {self.farthest_first!r:.40}"
            )
        require_counts(self, "count", max_count=MAX_SAMPLED if self.farthest_first else MAX_POINTS)
        require_counts(self, "azimuth_views", max_count=MAX_VIEWS)
        require_margin(self)

    @property
    def input_shape(self) -> tuple[int, ...]:
        """See `InputSpec.input_shape`."""
        return (self.count, 3)

    def inputs(self, cloud: PointCloud, yaws: Sequence[float] = (0.0,)) -> NDArray[np.float32]:
        """See `InputSpec.inputs`; the choice of points depends on the cloud alone."""
        frame = self.bounds(cloud)
        if self.surface and len(cloud) < self.count:
            cloud = fill_surface(cloud, self.count - len(cloud))
        points = (cloud.points_xyz - np.asarray(frame.centre_xyz)) / frame.radius
        points = self._drawn(points, np.random.default_rng(0))
        cell = 2 * np.pi / 32 / self.azimuth_views
        turns = [[yaw + cell * view for view in range(self.azimuth_views)] for yaw in yaws]
        return np.array([[turned(points, t) for t in row] for row in turns], np.float32)

    def of_samples(
        self, samples_xyz: NDArray[np.float32], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        """One input from samples of a normalised object, for training.

        Args:
            samples_xyz: (m, 3) about the axis, within a cylinder of radius 1.
            rng: Random generator.

        Returns:
            (count, 3).
        """
        return self._drawn(samples_xyz, rng).astype(np.float32)

    def _drawn(self, points_xyz: Points, rng: np.random.Generator) -> Points:
        """(count, 3) of (m, 3) points about the axis, in the order that the network expects."""
        drawn = points_xyz[_some(len(points_xyz), self.count, rng)]
        return drawn[_farthest_first(drawn)] if self.farthest_first else drawn

    def bounds(self, cloud: PointCloud) -> CylindricalGrid:
        """See `InputSpec.bounds`."""
        return cylinder_round(cloud, self.margin)

    def all_bounds(self, bounds: Grid, max_views: int | None = None) -> list[Grid]:  # noqa: ARG002
        """See `InputSpec.all_bounds`: points have one view, since there are no cells to turn."""
        return [bounds]

    def with_views(self, azimuth_views: int, dithered: bool = False) -> PointsSpec:
        """See `InputSpec.with_views`."""
        if dithered:
            raise InputError("points have no cells to dither; leave out --dithered")
        return replace(self, azimuth_views=azimuth_views)

    def with_margin(self, margin: float) -> PointsSpec:
        """See `InputSpec.with_margin`."""
        return replace(self, margin=margin)

    def accepts(self, grid: OccupancyGrid) -> None:  # noqa: ARG002 - none is
        """See `InputSpec.accepts`: no grid fits."""
        raise InputError("the classifier takes points, not grids; give it the cloud itself")

    def to_dict(self) -> dict[str, Any]:
        """See `InputSpec.to_dict`."""
        return asdict(self)


def _farthest_first(points_xyz: Points) -> NDArray[np.int64]:
    """(n,) the order of the points; a turn about the axis does not change it."""
    outermost = int(np.square(points_xyz).sum(axis=1).argmax())
    sample = farthest_points(points_xyz, len(points_xyz) // 2, outermost)
    rest = np.ones(len(points_xyz), bool)
    rest[sample] = False
    return np.concatenate([sample, np.flatnonzero(rest)])


def _some(there: int, wanted: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """`wanted` random indices; their frequencies differ by one at most."""
    rounds = -(-wanted // there)
    return np.concatenate([rng.permutation(there) for _ in range(rounds)])[:wanted]
