"""The grids of an object that turns: cylindrical ones shift, rectangular ones change (Fig. 10)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from circumspect.classification import GridRecipe
from circumspect.evaluation.figure_canvas import new_figure
from circumspect.evaluation.grid_picture import outermost_surface
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def turned_grids(
    cloud: PointCloud,
    shape: tuple[int, int, int],
    turns_deg: Sequence[float],
    margin: float = 1.0,
) -> dict[str, list[OccupancyGrid]]:
    """Kind of grid to the grids of a cloud at several yaws, within the same bounds.

    Args:
        cloud: A surface, z up.
        shape: Of the grids.
        turns_deg: Counter-clockwise, seen from above [degrees].
        margin: See `GridRecipe`.

    Raises:
        InputError: The margin is out of range.
        GeometryError: The cloud spans no grid.
    """
    found: dict[str, list[OccupancyGrid]] = {}
    for kind in ("cylindrical", "rectangular"):
        recipe = GridRecipe(kind=kind, shape=shape, margin=margin)
        bounds = recipe.bounds(cloud)
        points = recipe.surface(cloud).points_xyz
        grids = []
        for turn in turns_deg:
            turned = Rotation.from_euler("z", turn, degrees=True)
            centre = bounds.centre_xyz
            grids.append(bounds.hits(turned.apply(points - centre) + centre))
        found[kind] = grids
    return found


def changed_share(first: OccupancyGrid, other: OccupancyGrid, turn_deg: float) -> float:
    """Share of the cells occupied in either of two grids that differ.

    A cylindrical grid is rolled back by whole cells first: that is all that turning does to it.
    """
    back = other.occupied
    if isinstance(other.grid, CylindricalGrid):
        cells = other.grid.shape[1]
        back = np.roll(back, -round(turn_deg / 360.0 * cells), axis=1)
    either = first.occupied | back
    return float((first.occupied ^ back).sum() / max(1, either.sum()))


def draw_turning(grids: dict[str, list[OccupancyGrid]], turns_deg: Sequence[float]) -> Figure:
    """Above the cylindrical grids unrolled over azimuth, below the rectangular ones from above.

    Args:
        grids: As `turned_grids` gives them.
        turns_deg: Their turns [degrees].

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    count = len(turns_deg)
    figure = new_figure((3.1 * count, 5.8))
    axes = figure.subplots(2, count, squeeze=False)
    for column, turn in enumerate(turns_deg):
        cylindrical, rectangular = grids["cylindrical"][column], grids["rectangular"][column]
        above, below = axes[0][column], axes[1][column]
        bounds = cylindrical.grid
        assert isinstance(bounds, CylindricalGrid)
        extent = (0.0, 360.0, -bounds.half_height, bounds.half_height)
        above.imshow(
            outermost_surface(cylindrical).T, origin="lower", extent=extent, aspect="auto",
            cmap="viridis", vmin=0, vmax=bounds.radius,
        )  # fmt: skip
        above.set(xlabel="azimuth [°]")
        above.set_xticks(range(0, 361, 90))
        square = rectangular.grid
        assert isinstance(square, RectangularGrid)
        seen = rectangular.occupied.sum(axis=2).astype(float)
        seen[seen == 0] = np.nan
        half = square.half_width
        below.imshow(seen.T, origin="lower", extent=(-half, half, -half, half), cmap="magma_r")
        below.set(xlabel="x [m]")
        for panel, kind in ((above, "cylindrical"), (below, "rectangular")):
            share = changed_share(grids[kind][0], grids[kind][column], turn - turns_deg[0])
            rolled = ", rolled back" if kind == "cylindrical" else ""
            panel.set_title(f"{turn:g}°: {share:.0%} of the cells\ndiffer{rolled}", fontsize=9)
    axes[0][0].set_ylabel("cylindrical: height [m]")
    axes[1][0].set_ylabel("rectangular: y [m]")
    return figure
