"""The shortest free way over the floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose
from circumspect.planning.costmap import CELL, Costmap
from circumspect.planning.situation import Situation

NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2))
"""Steps between cells, each also backward: 16 directions."""
NEARNESS_COST = 4.0
"""A metre right beside the object costs as much as 1 + this many metres further away."""
TIGHT_COST = 30.0
"""A metre where the robot is too close to something already, before it got out."""
SPACING = 0.05
"""Between the places of a path [m]."""
SMOOTHINGS = 60
FARTHEST = 30.0
"""Beyond this [m] no way is looked for: the map of the floor would fill the memory."""


@dataclass(frozen=True, eq=False)
class Route:
    """A way that the robot can drive.

    Attributes:
        path_xy: (n, 2) [m] from the robot to the goal, n >= 2, about `SPACING` apart.
    """

    path_xy: NDArray[np.float64]

    @property
    def length(self) -> float:
        """[m]."""
        return float(np.linalg.norm(np.diff(self.path_xy, axis=0), axis=1).sum())


@dataclass(frozen=True)
class NoWay:
    """Why there is no way.

    Attributes:
        why: The reason in words.
    """

    why: str


def route(situation: Situation, goal: PlanarPose, keep: float = 0.0) -> Route | NoWay:
    """The cheapest way from the robot to a goal that stays clear of object and obstacles.

    Args:
        situation: Object, obstacles and robot.
        goal: Where to.
        keep: Distance to the object that is worth a detour [m]: nearer, the camera sees badly.

    Returns:
        The way, smoothed; or the reason why there is none.
    """
    if (away := float(np.linalg.norm(goal.xy - situation.T_map_base.xy))) > FARTHEST:
        return NoWay(f"{away:.0f} m away is too far to look for a way")
    costmap = Costmap.of(situation, goal.xy)
    here, there = costmap.cell(situation.T_map_base.xy), costmap.cell(goal.xy)
    free = costmap.free
    if not free[there]:
        if costmap.to_object[there] < costmap.radius:
            return NoWay(f"{costmap.to_object[there]:.2f} m from the object is too close for it")
        return NoWay(f"an obstacle stands {costmap.to_obstacle[there]:.2f} m away from there")
    price = _price(costmap, free, here, keep)
    cells = _cheapest(price, here, there)
    if cells is None:
        return NoWay("no free way leads there")
    places = np.vstack([situation.T_map_base.xy, costmap.middles(cells[1:-1]), goal.xy])
    return Route(_smoothed(places, costmap))


def passable(situation: Situation, path_xy: NDArray[np.float64]) -> bool:
    """Whether the rest of a way is still free of the object and of obstacles.

    Args:
        situation: Object, obstacles and robot.
        path_xy: (n, 2) [m] the way; what the robot has passed does not count.
    """
    passed = int(np.argmin(np.linalg.norm(path_xy - situation.T_map_base.xy, axis=1)))
    rest = path_xy[passed:]
    away = np.linalg.norm(rest - situation.T_map_base.xy, axis=1)
    rest = rest[away > situation.robot_radius]
    things = np.vstack([situation.footprint_xy, situation.obstacles_xy])
    if len(rest) == 0 or len(things) == 0:
        return True
    from scipy.spatial.distance import cdist

    return bool(cdist(rest, things).min() >= situation.robot_radius)


def _price(
    costmap: Costmap, free: NDArray[np.bool_], here: tuple[int, int], keep: float
) -> NDArray[np.float64]:
    """(nx, ny) cost of a metre in each cell; infinite where the robot can not be."""
    price = np.where(free, 1.0, np.inf)
    if keep > 0:
        nearness = np.clip(1 - costmap.to_object / keep, 0, 1)
        price += NEARNESS_COST * nearness
    # One that stands too close to something gets out on the shortest way, getting no closer.
    clearance = np.minimum(costmap.to_object, costmap.to_obstacle)
    reach = int(np.ceil(costmap.radius / CELL)) + 1
    x, y = np.indices(free.shape)
    way_out = np.hypot(x - here[0], y - here[1]) <= reach
    way_out &= ~free & (clearance >= clearance[here] - CELL)
    if not free[here]:
        price[way_out] = TIGHT_COST
    return price


def _cheapest(
    price: NDArray[np.float64], here: tuple[int, int], there: tuple[int, int]
) -> NDArray[np.intp] | None:
    """(n, 2) cells from here to there; None without a way."""
    from scipy.sparse.csgraph import dijkstra

    start, end = (int(np.ravel_multi_index(cell, price.shape)) for cell in (here, there))
    _, before = dijkstra(_graph(price), directed=False, indices=start, return_predecessors=True)
    if before[end] < 0 and start != end:
        return None
    chain = [end]
    while chain[-1] != start:
        chain.append(int(before[chain[-1]]))
    return np.array(np.unravel_index(chain[::-1], price.shape)).T


def _graph(price: NDArray[np.float64]):
    """Costs of the steps between cells that are both open."""
    from scipy.sparse import coo_array

    nx, ny = price.shape
    index = np.arange(nx * ny).reshape(nx, ny)
    rows, columns, costs = [], [], []
    for dx, dy in NEIGHBOURS:
        first = (slice(0, nx - dx), slice(max(0, -dy), ny - max(0, dy)))
        second = (slice(dx, nx), slice(max(0, dy), ny + min(0, dy)))
        mean = (price[first] + price[second]) / 2
        open_both = np.isfinite(mean)
        rows.append(index[first][open_both])
        columns.append(index[second][open_both])
        costs.append(mean[open_both] * CELL * np.hypot(dx, dy))
    joined = (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns)))
    return coo_array(joined, shape=(nx * ny, nx * ny)).tocsr()


def _smoothed(places_xy: NDArray[np.float64], costmap: Costmap) -> NDArray[np.float64]:
    """Evenly spaced, without the grid's corners, still free wherever it was."""
    path = _spaced(places_xy)
    for _ in range(SMOOTHINGS):
        pulled = path.copy()
        pulled[1:-1] += 0.25 * (path[:-2] - 2 * path[1:-1] + path[2:])
        clear = costmap.clearance(pulled) >= costmap.radius
        path = np.where(clear[:, None], pulled, path)
    return _spaced(path)


def _spaced(places_xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Places at even distances along the same line, ends included."""
    lengths = np.linalg.norm(np.diff(places_xy, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    count = max(2, round(along[-1] / SPACING) + 1)
    wanted = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(wanted, along, axis) for axis in places_xy.T], axis=1)
