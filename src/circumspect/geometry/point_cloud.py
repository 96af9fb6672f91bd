"""Points on a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points on the surface of an object; arrays are read-only.

    Attributes:
        points_xyz: (n, 3) float64 [m], finite, n >= 1.
        areas: (n,) float64 [m²] or None: the surface area that each point stands for. None
            means that all points stand for the same area.
        normals_xyz: (n, 3) float64 unit vectors or None.

    Raises:
        GeometryError: Wrong shapes, no points, or coordinates that are not finite.
    """

    points_xyz: NDArray[np.float64]
    areas: NDArray[np.float64] | None = None
    normals_xyz: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        points = _frozen(self.points_xyz)
        if points.ndim != 2 or points.shape[1] != 3:
            raise GeometryError(f"points must have shape (n, 3), not {points.shape}")
        if len(points) == 0:
            raise GeometryError("the cloud is empty; at least one point is needed")
        if not np.isfinite(points).all():
            bad = int((~np.isfinite(points)).any(axis=1).sum())
            raise GeometryError(
                f"{bad} of {len(points)} points are NaN or infinite; remove them first"
            )
        object.__setattr__(self, "points_xyz", points)
        for name, shape in (("areas", (len(points),)), ("normals_xyz", points.shape)):
            value = getattr(self, name)
            if value is None:
                continue
            value = _frozen(value)
            if value.shape != shape:
                raise GeometryError(f"{name} must have shape {shape}, not {value.shape}")
            if not np.isfinite(value).all():
                raise GeometryError(f"{name} holds NaN or infinite values")
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.points_xyz)

    @property
    def weights(self) -> NDArray[np.float64]:
        """(n,) shares of the whole surface; they sum to 1."""
        if self.areas is None or not (total := float(self.areas.sum())) > 0:
            return np.full(len(self), 1.0 / len(self))
        return self.areas / total

    def moved(self, matrix: ArrayLike) -> PointCloud:
        """The cloud under a homogeneous transform.

        Args:
            matrix: (4, 4) `T_target_source`, a similarity (rotation, scale, translation).

        Returns:
            The cloud in the target frame; areas grow with the square of the scale.
        """
        T_target_source = np.asarray(matrix, dtype=np.float64)
        linear, translation = T_target_source[:3, :3], T_target_source[:3, 3]
        scale = float(np.cbrt(abs(np.linalg.det(linear))))
        return PointCloud(
            self.points_xyz @ linear.T + translation,
            areas=None if self.areas is None else self.areas * scale**2,
            normals_xyz=None if self.normals_xyz is None else self.normals_xyz @ linear.T / scale,
        )


def _frozen(values: ArrayLike) -> NDArray[np.float64]:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array
