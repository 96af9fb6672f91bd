"""Points on a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from circumspect.errors import GeometryError
from circumspect.geometry import _native
from circumspect.geometry.frozen_array import (
    ReadOnlyArrays,
    frozen,
    require_coordinates,
    rows_of_fields,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from scipy.spatial.transform import RigidTransform

_SIMILARITY_TOLERANCE = 1e-6
MAX_SHOWN_POINTS = 40_000
"""Of a cloud in a picture."""
# A shape thinner than this fraction of its length in two directions is a line.
LINE_RATIO = 1e-6


@dataclass(frozen=True, eq=False)
class PointCloud(ReadOnlyArrays):
    """Points on the surface of an object; arrays are read-only.

    NumPy takes a cloud as the array of its points.

    Attributes:
        points_xyz: (n, 3) float64 [m], finite, n >= 1. May be given as a structured array with
            fields x, y and z.
        areas: (n,) float64 [m²] or None: the surface area that each point stands for. None
            means that all points stand for the same area.
        normals_xyz: (n, 3) float64 unit vectors or None.

    Raises:
        GeometryError: Wrong shapes, no points, coordinates that are not finite, negative areas,
            masked values, or values that are no whole or real numbers.
    """

    points_xyz: NDArray[np.float64]
    areas: NDArray[np.float64] | None = None
    normals_xyz: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        points = frozen(rows_of_fields(self.points_xyz))
        require_coordinates(points, "points")
        object.__setattr__(self, "points_xyz", points)
        for name, shape in (("areas", (len(points),)), ("normals_xyz", points.shape)):
            given = getattr(self, name)
            if given is None:
                continue
            values = frozen(given)
            if values.shape != shape:
                raise GeometryError(f"{name} must have shape {shape}, not {values.shape}")
            if not np.isfinite(values).all():
                raise GeometryError(f"{name} holds NaN or infinite values")
            object.__setattr__(self, name, values)
        if self.areas is not None and float(self.areas.min()) < 0:
            raise GeometryError("areas holds negative values")

    def __len__(self) -> int:
        return len(self.points_xyz)

    def __repr__(self) -> str:
        areas = "" if self.areas is None else ", areas"
        normals = "" if self.normals_xyz is None else ", normals"
        return f"PointCloud({len(self)} points{areas}{normals})"

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """(n, 3) [m]: the points; read-only unless copied."""
        return np.array(self.points_xyz, dtype=dtype, copy=copy)

    @property
    def weights(self) -> NDArray[np.float64]:
        """(n,) fractions of the whole surface; they sum to 1."""
        if self.areas is None or not (largest := float(self.areas.max())) > 0:
            return np.full(len(self), 1.0 / len(self))
        shares = self.areas / largest
        return shares / shares.sum()

    def part(self, chosen: NDArray[np.bool_]) -> PointCloud:
        """Some of the points, with their areas and normals.

        Args:
            chosen: (n,) True for each point to keep; at least one.
        """
        return PointCloud(
            self.points_xyz[chosen],
            areas=None if self.areas is None else self.areas[chosen],
            normals_xyz=None if self.normals_xyz is None else self.normals_xyz[chosen],
        )

    def thinned(self, most: int) -> PointCloud:
        """At most so many of the points, evenly picked; areas are left out."""
        step = -(-len(self) // most)
        if step == 1:
            return self
        normals = None if self.normals_xyz is None else self.normals_xyz[::step]
        return PointCloud(self.points_xyz[::step], normals_xyz=normals)

    def moved(self, T_target_source: RigidTransform | ArrayLike) -> PointCloud:
        """The cloud under a homogeneous transform.

        Args:
            T_target_source: A rigid transform, or the (4, 4) matrix of a similarity (rotation,
                scale, translation; a mirror is allowed).

        Returns:
            The cloud in the target frame; areas grow with the square of the scale.

        Raises:
            GeometryError: The matrix is no similarity.
        """
        matrix = _matrix(T_target_source)
        scale = _similarity_scale(matrix)
        linear, translation = matrix[:3, :3], matrix[:3, 3]
        return PointCloud(
            self.points_xyz @ linear.T + translation,
            areas=None if self.areas is None else self.areas * scale**2,
            normals_xyz=None if self.normals_xyz is None else self.normals_xyz @ (linear.T / scale),
        )

    def turned(self, yaw: float) -> PointCloud:
        """The cloud turned about the z axis.

        Args:
            yaw: [rad], counter-clockwise seen from above.

        Raises:
            GeometryError: The angle is not finite.
        """
        if not np.isfinite(yaw):
            raise GeometryError(f"a cloud is turned by a finite angle, not by {yaw}")
        matrix = np.eye(4)
        matrix[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
        return self.moved(matrix)

    def plot(
        self, axes: Axes | None = None, azimuth_deg: float = -60.0, elevation_deg: float = 25.0
    ) -> Axes:
        """Draw the surface as seen from far away.

        Args:
            axes: Where to draw; None for a new figure.
            azimuth_deg: Where the eye is, seen from the object [degrees].
            elevation_deg: The same, above the horizon [degrees].

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        from circumspect.figure_canvas import axes_or_new
        from circumspect.geometry.cloud_plot import draw_cloud

        axes = axes_or_new(axes, (5.0, 5.0))
        shown = self.thinned(MAX_SHOWN_POINTS)
        draw_cloud(axes, shown.points_xyz, shown.normals_xyz, azimuth_deg, elevation_deg)
        return axes


def _matrix(transform: RigidTransform | ArrayLike) -> NDArray[np.float64]:
    from scipy.spatial.transform import RigidTransform

    if isinstance(transform, RigidTransform):
        return frozen(transform.as_matrix())
    return frozen(transform)


def _similarity_scale(matrix: NDArray[np.float64]) -> float:
    if matrix.shape != (4, 4):
        raise GeometryError(f"a transform must have shape (4, 4), not {matrix.shape}")
    if not np.isfinite(matrix).all() or not np.array_equal(matrix[3], [0, 0, 0, 1]):
        raise GeometryError("a transform must be finite, with the last row 0 0 0 1")
    linear = matrix[:3, :3]
    scale = float(np.linalg.norm(linear)) / np.sqrt(3)
    if not scale > 0 or not np.allclose(
        (linear / scale) @ (linear / scale).T, np.eye(3), rtol=0, atol=_SIMILARITY_TOLERANCE
    ):
        raise GeometryError("a transform must turn, move and scale alike in all directions")
    return float(scale)


def require_extent(cloud: PointCloud) -> None:
    """Check that the points span at least a plane, at any scale and offset.

    Raises:
        GeometryError: One point, all points in one place, or all on a line.
    """
    points = cloud.points_xyz
    if len(points) == 1:
        raise GeometryError("has a single point; a shape needs many")
    low, high, scatter = _native.extent(points)
    spread = float((high - low).max())
    if spread <= 16 * np.finfo(np.float64).eps * float(max(-low.min(), high.max())):
        raise GeometryError(f"all {len(points)} points lie in one place; a shape needs an extent")
    deviations = np.sqrt(np.linalg.eigvalsh(scatter).clip(min=0))
    if deviations[1] <= LINE_RATIO * deviations[2]:
        raise GeometryError(f"all {len(points)} points lie on a line; a shape needs a surface")
