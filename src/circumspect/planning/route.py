"""Shortest free path over the floor on a costmap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose
from circumspect.planning.planner_input import PlannerInput

NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2))
"""Steps between cells; with their opposites, 16 directions."""
NEARNESS_COST = 4.0
"""Additional cost of a metre directly next to the object."""
TIGHT_COST = 30.0
"""Cost of a metre within the safety distance, from which the robot must get out."""
SPACING_M = 0.05
"""Distance between the points of a path [m]."""
SMOOTHING_ITERATIONS = 60
MAX_ROUTE_M = 30.0
"""Maximum distance to a goal [m]; larger maps would need too much memory."""
CELL_M = 0.05
"""Side of the cells [m]."""
MAP_MARGIN_M = 1.5
"""Margin of the map around everything known [m]."""
UNKNOWN_DISTANCE_M = 1e3
"""Distance to object and obstacles if none is known [m]."""
SAFETY_MARGIN_M = 0.05
"""Distance to obstacles in addition to the radius of the robot [m]."""


@dataclass(frozen=True, eq=False)
class Costmap:
    """Distances to object and obstacles on a grid.

    Attributes:
        low_xy: (2,) corner of the cell (0, 0) [m].
        to_object: (nx, ny) distance from the centre of a cell to the object [m]; 0 in its convex
            hull.
        to_obstacle: (nx, ny) distance to other obstacles [m].
        radius: Minimum distance of the robot's centre [m].
    """

    low_xy: NDArray[np.float64]
    to_object: NDArray[np.float64]
    to_obstacle: NDArray[np.float64]
    radius: float

    @classmethod
    def of(cls, planner_input: PlannerInput, *places_xy: NDArray[np.float64]) -> Costmap:
        """Create the map.

        The convex hull of the object counts as object: the robot does not drive between the legs of
            a table, and unseen sides are not free.

        Args:
            planner_input: Object, obstacles and robot.
            places_xy: (2,) positions that must be on the map [m].
        """
        flat = planner_input.footprint_xy
        everything = np.vstack([flat, planner_input.T_map_base.xy, *places_xy])
        low = everything.min(axis=0) - MAP_MARGIN_M
        shape = np.ceil((everything.max(axis=0) + MAP_MARGIN_M - low) / CELL_M).astype(int)
        middles = low + (np.indices(shape).transpose(1, 2, 0) + 0.5) * CELL_M
        occupied = _marked(flat, low, shape) | _in_hull(flat, middles)
        other = _marked(planner_input.obstacles_xy, low, shape)
        radius = planner_input.robot_radius + SAFETY_MARGIN_M
        return cls(low, _distance(occupied), _distance(other), radius)

    @property
    def free(self) -> NDArray[np.bool_]:
        """(nx, ny) cells that the robot's centre may occupy."""
        return np.minimum(self.to_object, self.to_obstacle) >= self.radius

    def clearance(self, places_xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) distance from (n, 2) positions to object and obstacles [m], interpolated."""
        from scipy import ndimage

        # A finite value, so that interpolation works on an empty map.
        nearest = np.minimum(np.minimum(self.to_object, self.to_obstacle), UNKNOWN_DISTANCE_M)
        at = (places_xy - self.low_xy) / CELL_M - 0.5
        return ndimage.map_coordinates(nearest, at.T, order=1, mode="nearest")

    def cell(self, place_xy: NDArray[np.float64]) -> tuple[int, int]:
        """The cell of a (2,) position [m]."""
        x, y = np.floor((np.asarray(place_xy) - self.low_xy) / CELL_M).astype(int)
        return int(x), int(y)

    def middles(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """(n, 2) centres of (n, 2) cells [m]."""
        return self.low_xy + (cells + 0.5) * CELL_M


def _marked(
    places_xy: NDArray[np.float64], low_xy: NDArray[np.float64], shape: NDArray[np.integer]
) -> NDArray[np.bool_]:
    """Cells that contain a position; positions outside the map are ignored."""
    grid = np.zeros(shape, bool)
    cells = np.floor((places_xy - low_xy) / CELL_M).astype(int)
    cells = cells[((cells >= 0) & (cells < shape)).all(axis=1)]
    grid[cells[:, 0], cells[:, 1]] = True
    return grid


def _in_hull(
    footprint_xy: NDArray[np.float64], middles_xy: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Cells in the convex hull; none if the footprint has no area."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        planes = ConvexHull(footprint_xy).equations
    except (QhullError, ValueError):
        return np.zeros(middles_xy.shape[:2], bool)
    return np.all(middles_xy @ planes[:, :2].T + planes[:, 2] <= 0, axis=-1)


def _distance(marked: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Distance from each cell to the nearest marked one [m]; infinite if there is none."""
    from scipy import ndimage

    if not marked.any():
        return np.full(marked.shape, np.inf)
    return CELL_M * np.asarray(ndimage.distance_transform_edt(~marked))


@dataclass(frozen=True, eq=False)
class Route:
    """A path for the robot.

    Attributes:
        path_xy: (n, 2) from the robot to the goal [m], n >= 2, about `SPACING_M` apart.
    """

    path_xy: NDArray[np.float64]

    @property
    def length(self) -> float:
        """[m]."""
        return float(np.linalg.norm(np.diff(self.path_xy, axis=0), axis=1).sum())


@dataclass(frozen=True)
class NoPath:
    """There is no path.

    Attributes:
        reason: Why there is none.
    """

    reason: str


def route(
    planner_input: PlannerInput, goal: PlanarPose, preferred_distance: float = 0.0
) -> Route | NoPath:
    """Find the cheapest path to a goal that keeps clear of object and obstacles.

    Args:
        planner_input: Object, obstacles and robot.
        goal: Goal pose.
        preferred_distance: Distance to the object that is worth a detour [m]; nearer, the camera
            sees little.

    Returns:
        The smoothed path, or the reason why there is none.
    """
    if (away := float(np.linalg.norm(goal.xy - planner_input.T_map_base.xy))) > MAX_ROUTE_M:
        return NoPath(f"{away:.0f} m away is too far for a path")
    costmap = Costmap.of(planner_input, goal.xy)
    here, there = costmap.cell(planner_input.T_map_base.xy), costmap.cell(goal.xy)
    free = costmap.free
    if not free[there]:
        if costmap.to_object[there] < costmap.radius:
            return NoPath(f"{costmap.to_object[there]:.2f} m from the object is too close for it")
        return NoPath(f"an obstacle stands {costmap.to_obstacle[there]:.2f} m away from there")
    cost = _cost(costmap, free, here, preferred_distance)
    cells = _cheapest_path(cost, here, there)
    if cells is None:
        return NoPath("there is no free path")
    places = np.vstack([planner_input.T_map_base.xy, costmap.middles(cells[1:-1]), goal.xy])
    return Route(_smoothed(places, costmap))


def is_free(planner_input: PlannerInput, path_xy: NDArray[np.float64]) -> bool:
    """Whether the remaining part of a path is free of object and obstacles.

    Args:
        planner_input: Object, obstacles and robot.
        path_xy: (n, 2) path [m]; the part behind the robot is ignored.
    """
    passed = int(np.argmin(np.linalg.norm(path_xy - planner_input.T_map_base.xy, axis=1)))
    rest = path_xy[passed:]
    away = np.linalg.norm(rest - planner_input.T_map_base.xy, axis=1)
    rest = rest[away > planner_input.robot_radius]
    occupied_xy = np.vstack([planner_input.footprint_xy, planner_input.obstacles_xy])
    if len(rest) == 0 or len(occupied_xy) == 0:
        return True
    from scipy.spatial.distance import cdist

    return bool(cdist(rest, occupied_xy).min() >= planner_input.robot_radius)


def _cost(
    costmap: Costmap, free: NDArray[np.bool_], here: tuple[int, int], preferred_distance: float
) -> NDArray[np.float64]:
    """(nx, ny) cost of a metre in each cell; infinite where the robot cannot be."""
    cost = np.where(free, 1.0, np.inf)
    if preferred_distance > 0:
        nearness = np.clip(1 - costmap.to_object / preferred_distance, 0, 1)
        cost += NEARNESS_COST * nearness
    # A robot that is too close to something leaves on the shortest path without getting closer.
    clearance = np.minimum(costmap.to_object, costmap.to_obstacle)
    reach = int(np.ceil(costmap.radius / CELL_M)) + 1
    x, y = np.indices(free.shape)
    way_out = np.hypot(x - here[0], y - here[1]) <= reach
    way_out &= ~free & (clearance >= clearance[here] - CELL_M)
    if not free[here]:
        cost[way_out] = TIGHT_COST
    return cost


def _cheapest_path(
    cost: NDArray[np.float64], here: tuple[int, int], there: tuple[int, int]
) -> NDArray[np.intp] | None:
    """(n, 2) cells of the cheapest path; None if there is none."""
    from scipy.sparse.csgraph import dijkstra

    start, end = (int(np.ravel_multi_index(cell, cost.shape)) for cell in (here, there))
    _, before = dijkstra(_graph(cost), directed=False, indices=start, return_predecessors=True)
    if before[end] < 0 and start != end:
        return None
    chain = [end]
    while chain[-1] != start:
        chain.append(int(before[chain[-1]]))
    return np.array(np.unravel_index(chain[::-1], cost.shape)).T


def _graph(cost: NDArray[np.float64]):
    """Costs of the steps between free cells."""
    from scipy.sparse import coo_array

    nx, ny = cost.shape
    index = np.arange(nx * ny).reshape(nx, ny)
    rows, columns, costs = [], [], []
    for dx, dy in NEIGHBOURS:
        first = (slice(0, nx - dx), slice(max(0, -dy), ny - max(0, dy)))
        second = (slice(dx, nx), slice(max(0, dy), ny + min(0, dy)))
        mean = (cost[first] + cost[second]) / 2
        open_both = np.isfinite(mean)
        rows.append(index[first][open_both])
        columns.append(index[second][open_both])
        costs.append(mean[open_both] * CELL_M * np.hypot(dx, dy))
    joined = (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns)))
    return coo_array(joined, shape=(nx * ny, nx * ny)).tocsr()


def _smoothed(places_xy: NDArray[np.float64], costmap: Costmap) -> NDArray[np.float64]:
    """Smooth a path and space its points evenly, keeping it free."""
    path = _spaced(places_xy)
    for _ in range(SMOOTHING_ITERATIONS):
        pulled = path.copy()
        pulled[1:-1] += 0.25 * (path[:-2] - 2 * path[1:-1] + path[2:])
        clear = costmap.clearance(pulled) >= costmap.radius
        path = np.where(clear[:, None], pulled, path)
    return _spaced(path)


def _spaced(places_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Evenly spaced points along a path, including its ends."""
    lengths = np.linalg.norm(np.diff(places_xy, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    count = max(2, round(along[-1] / SPACING_M) + 1)
    wanted = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(wanted, along, axis) for axis in places_xy.T], axis=1)
