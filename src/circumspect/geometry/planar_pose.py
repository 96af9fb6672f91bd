"""Position and heading on the floor, and angles within one turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError
from circumspect.geometry.composition import orthonormal

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform

Angle = TypeVar("Angle", float, NDArray[np.floating])


@dataclass(frozen=True)
class PlanarPose:
    """A pose in the plane z = 0 of its frame; a member of SE(2).

    `T_a_b @ T_b_c` is `T_a_c`.

    Attributes:
        x, y: Position [m].
        yaw: Heading [rad], counter-clockwise from +x; kept within (-π, π].

    Raises:
        GeometryError: A value is not finite.
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def __post_init__(self) -> None:
        if not np.isfinite([self.x, self.y, self.yaw]).all():
            raise GeometryError(f"a planar pose must be finite, not {self.x, self.y, self.yaw}")
        wrapped = float(np.pi - np.mod(np.pi - self.yaw, 2 * np.pi))
        for name, value in (("x", float(self.x)), ("y", float(self.y)), ("yaw", wrapped)):
            object.__setattr__(self, name, value)

    @classmethod
    def from_transform(cls, T: RigidTransform) -> PlanarPose:
        """The pose without height, roll and pitch."""
        matrix = T.as_matrix()
        yaw = np.arctan2(matrix[1, 0], matrix[0, 0])
        return cls(float(matrix[0, 3]), float(matrix[1, 3]), float(yaw))

    def as_transform(self) -> RigidTransform:
        """The pose in space, at height 0."""
        return orthonormal(self.as_matrix())

    def as_matrix(self) -> NDArray[np.float64]:
        """(4, 4) matrix of `as_transform`."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        matrix = np.eye(4)
        matrix[:2] = [[cosine, -sine, 0.0, self.x], [sine, cosine, 0.0, self.y]]
        return matrix

    @property
    def xy(self) -> NDArray[np.float64]:
        """(2,) [m]."""
        return np.array([self.x, self.y])

    @property
    def heading_xy(self) -> NDArray[np.float64]:
        """(2,) unit vector forward."""
        return np.array([np.cos(self.yaw), np.sin(self.yaw)])

    def __matmul__(self, other: PlanarPose) -> PlanarPose:
        x, y = self.applied(other.xy)
        return PlanarPose(x, y, self.yaw + other.yaw)

    def inverse(self) -> PlanarPose:
        """`T_b_a` of `T_a_b`."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        return PlanarPose(
            -cosine * self.x - sine * self.y, sine * self.x - cosine * self.y, -self.yaw
        )

    def applied(self, points_xy: ArrayLike) -> NDArray[np.float64]:
        """Map points from the pose's own frame.

        Args:
            points_xy: (2,) or (n, 2) [m].

        Returns:
            The same shape [m].
        """
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        return np.asarray(points_xy) @ np.array([[cosine, sine], [-sine, cosine]]) + self.xy


def wrapped(angle: Angle) -> Angle:
    """The equivalent angle [rad] within ± π."""
    return (angle + np.pi) % (2 * np.pi) - np.pi
