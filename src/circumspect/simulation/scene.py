"""Surfaces of a simulated room, and their footprints as obstacles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry import PlanarPose, TriangleMesh

NON_OBSTACLES = ("floor", "object")
CELL_M = 0.04
"""Side of the cells of a footprint [m]."""
MIN_OBSTACLE_HEIGHT_M = 0.03
"""Height below which the robot drives over obstacles [m]."""
MAX_SAMPLES = 400_000


@dataclass(frozen=True, eq=False)
class Surface:
    """One mesh with a colour.

    Attributes:
        name: Kind of surface: "object", "floor", …
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
        surfaces: All surfaces; hits of rays are indices into this tuple.
    """

    surfaces: tuple[Surface, ...]

    @classmethod
    def with_object(cls, mesh: TriangleMesh, *others: Surface, half_width: float = 10.0) -> Scene:
        """A scene with an object, a floor and other surfaces.

        Args:
            mesh: The object [m], standing on z = 0.
            others: Other surfaces, such as walls and clutter.
            half_width: Half the side of the floor [m].
        """
        scanned = Surface("object", mesh, (0.80, 0.56, 0.36))
        ground = Surface("floor", floor(half_width), (0.62, 0.64, 0.67))
        return cls((scanned, ground, *others))


def floor(half_width: float) -> TriangleMesh:
    """A square of side 2 `half_width` [m] at z = 0."""
    w = half_width
    corners = np.array([[-w, -w, 0], [w, -w, 0], [w, w, 0], [-w, w, 0]], dtype=np.float64)
    return TriangleMesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def block(
    low_xyz: tuple[float, float, float], high_xyz: tuple[float, float, float]
) -> TriangleMesh:
    """An axis-aligned box.

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
        radius: Radius [m].
        bottom: Lowest height [m].
        top: Highest height [m].
        sides: Number of faces around the axis.
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


def moved_mesh(mesh: TriangleMesh, pose: PlanarPose) -> TriangleMesh:
    """Move a mesh on the floor.

    Args:
        mesh: The mesh at the origin [m].
        pose: Its new pose.
    """
    xy = pose.applied(mesh.vertices_xyz[:, :2])
    return TriangleMesh(np.column_stack([xy, mesh.vertices_xyz[:, 2]]), mesh.faces)


def outlines(scene: Scene) -> tuple[NDArray[np.float64], ...]:
    """Convex outlines, seen from above, of all surfaces except the floor and the object.

    Args:
        scene: The scene.

    Returns:
        Closed polygons, each (k, 2) [m] with the first corner repeated at the end.

    Raises:
        GeometryError: A surface has no width from above.
    """
    from scipy.spatial import ConvexHull, QhullError

    found = []
    for surface in scene.surfaces:
        if surface.name in NON_OBSTACLES:
            continue
        points = surface.mesh.vertices_xyz[:, :2]
        try:
            corners = points[ConvexHull(points).vertices]
        except QhullError as error:
            raise GeometryError(f"the surface '{surface.name}' has no width from above") from error
        found.append(np.vstack([corners, corners[:1]]))
    return tuple(found)


def footprint_boxes(scene: Scene, height: float) -> NDArray[np.float64]:
    """Rectangles on the floor that cover all surfaces except those named "floor".

    A robot with a mast cannot drive under a table that its mast would hit. Every surface from
    `MIN_OBSTACLE_HEIGHT_M` to the mast's `height` is therefore a column down to the floor. The
    rectangles are whole cells of `CELL_M` and extend up to a cell beyond the surface. Closed bodies
    are hollow, because the robot cannot enter them.

    Args:
        scene: The scene.
        height: Height of the robot [m].

    Returns:
        (n, 4) [m]: smallest x and y, largest x and y.
    """
    rectangles: list[NDArray[np.floating]] = [np.empty((0, 4))]
    for surface in scene.surfaces:
        if surface.name == "floor":
            continue
        mesh = surface.mesh
        count = int(np.clip(mesh.areas.sum() / (CELL_M / 2) ** 2, 100, MAX_SAMPLES))
        points = np.concatenate([mesh.sampled(count, 0).points_xyz, mesh.vertices_xyz])
        within = points[(points[:, 2] > MIN_OBSTACLE_HEIGHT_M) & (points[:, 2] < height)]
        if len(within):
            rectangles.append(_covering(np.floor(within[:, :2] / CELL_M).astype(np.intp)) * CELL_M)
    return np.concatenate(rectangles).astype(np.float64)


def _covering(cells: NDArray[np.intp]) -> NDArray[np.int64]:
    """(n, 4) rectangles of whole cells that cover exactly the given (m, 2) cells."""
    low = cells.min(axis=0)
    columns, rows = (int(size) for size in cells.max(axis=0) - low + 1)
    free = np.zeros((columns, rows), dtype=bool)
    free[tuple((cells - low).T)] = True
    found = []
    while free.any():
        x, y = divmod(int(free.argmax()), rows)
        ends = np.flatnonzero(~free[x, y:])
        y_end = int(y + ends[0]) if len(ends) else rows
        full = free[x:, y:y_end].all(axis=1)
        x_end = int(x + full.argmin()) if not full.all() else columns
        free[x:x_end, y:y_end] = False
        found.append((x, y, x_end, y_end))
    return np.array(found) + np.tile(low, 2)
