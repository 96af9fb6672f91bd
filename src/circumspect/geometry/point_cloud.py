"""Points on a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from circumspect.errors import GeometryError
from circumspect.geometry.frozen_array import ReadOnlyArrays, frozen, require_coordinates
from circumspect.geometry.point_fields import rows_of_fields

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform

_SIMILARITY_TOLERANCE = 1e-6


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
        """(n,) shares of the whole surface; they sum to 1."""
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
