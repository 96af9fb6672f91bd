"""What stands in a simulated room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.geometry import PlanarPose, TriangleMesh


@dataclass(frozen=True, eq=False)
class Surface:
    """One mesh with a colour.

    Attributes:
        name: What it is: "object", "floor", …
        mesh: Its surface in the map frame [m].
        colour: RGB, each 0 … 1.
    """

    name: str
    mesh: TriangleMesh
    colour: tuple[float, float, float] = (0.7, 0.7, 0.7)


@dataclass(frozen=True, eq=False)
class Scene:
    """Surfaces in the map frame; the floor is z = 0.

    Attributes:
        surfaces: All of them; a ray reports an index into this tuple.
    """

    surfaces: tuple[Surface, ...]

    @classmethod
    def with_object(cls, mesh: TriangleMesh, *others: Surface, half_width: float = 10.0) -> Scene:
        """An object on a floor, and whatever else is given.

        Args:
            mesh: The object [m], standing on z = 0.
            others: Walls, clutter.
            half_width: Of the floor [m].
        """
        thing = Surface("object", mesh, (0.80, 0.56, 0.36))
        ground = Surface("floor", floor(half_width), (0.62, 0.64, 0.67))
        return cls((thing, ground, *others))


def floor(half_width: float) -> TriangleMesh:
    """A square of side 2 `half_width` [m] at z = 0."""
    w = half_width
    corners = np.array([[-w, -w, 0], [w, -w, 0], [w, w, 0], [-w, w, 0]], dtype=np.float64)
    return TriangleMesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def block(
    low_xyz: tuple[float, float, float], high_xyz: tuple[float, float, float]
) -> TriangleMesh:
    """A box with edges along the axes: walls, clutter.

    Args:
        low_xyz: Corner with the smallest coordinates [m].
        high_xyz: The opposite corner [m].
    """
    low, high = np.asarray(low_xyz, float), np.asarray(high_xyz, float)
    unit = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return TriangleMesh(low + unit * (high - low), np.array(faces))


def cylinder(radius: float, bottom: float, top: float, sides: int = 24) -> TriangleMesh:
    """An upright cylinder about the z axis, closed.

    Args:
        radius: [m].
        bottom: Lowest height [m].
        top: Highest height [m].
        sides: How many faces go round.
    """
    azimuth = np.arange(sides) * (2 * np.pi / sides)
    ring = radius * np.column_stack([np.cos(azimuth), np.sin(azimuth)])
    rims = [np.column_stack([ring, np.full(sides, height)]) for height in (bottom, top)]
    vertices = np.concatenate([*rims, [[0, 0, bottom], [0, 0, top]]])
    this, after = np.arange(sides), np.roll(np.arange(sides), -1)
    low, high = np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    faces = [
        np.column_stack([this, after, after + sides]),
        np.column_stack([this, after + sides, this + sides]),
        np.column_stack([after, this, low]),
        np.column_stack([this + sides, after + sides, high]),
    ]
    return TriangleMesh(vertices, np.concatenate(faces))


def carried(mesh: TriangleMesh, pose: PlanarPose) -> TriangleMesh:
    """A mesh that was made at the origin, set down elsewhere on the floor.

    Args:
        mesh: [m].
        pose: To where.
    """
    xy = pose.applied(mesh.vertices_xyz[:, :2])
    return TriangleMesh(np.column_stack([xy, mesh.vertices_xyz[:, 2]]), mesh.faces)
