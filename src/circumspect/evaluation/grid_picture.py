"""Pictures of one grid, and of the grids of a turned object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from circumspect.classification import GridSpec
from circumspect.figure_canvas import new_figure
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid
from circumspect.grid.grid_plot import draw_projection

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage


def draw_grid(grid: OccupancyGrid, unit: str = "m") -> Figure:
    """The outermost surface unrolled over azimuth, the plan, and the profile.

    A rectangular grid is shown from above, the front and the side.

    Args:
        grid: The grid.
        unit: Of its bounds, as the axes name it.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    if isinstance(grid.grid, CylindricalGrid):
        return _draw_cylindrical(grid, unit)
    return _draw_rectangular(grid, unit)


def _draw_cylindrical(grid: OccupancyGrid, unit: str) -> Figure:
    bounds = grid.grid
    assert isinstance(bounds, CylindricalGrid)
    azimuths, occupied = bounds.shape[1], grid.occupied
    figure = new_figure((13.5, 4.2))
    wide, plan, profile = figure.subplots(
        1, 3, width_ratios=(2.0, 1.5, 0.9), gridspec_kw={"wspace": 0.06}
    )
    bounds.draw(wide, grid, unit)
    wide.set_title("", loc="left")
    wide.set_title("unrolled; grey: unknown, white: free")
    shown = _draw_plan(plan, occupied.sum(axis=2), bounds)
    plan.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]", title="plan")
    figure.colorbar(shown, ax=plan, label="cells over height", shrink=0.8)
    count = occupied.sum(axis=1)
    middle = bounds.centre_xyz[2]
    extent = (0.0, bounds.radius, middle - bounds.half_height, middle + bounds.half_height)
    shown = profile.imshow(
        _nonzero(count).T, origin="lower", extent=extent, cmap="magma_r", vmin=0, vmax=azimuths
    )
    figure.colorbar(shown, ax=profile, label="cells over azimuth")
    profile.set(xlabel=f"radius [{unit}]", ylabel=f"height z [{unit}]", title="profile")
    profile.set_ylim(wide.get_ylim())
    return figure


def _draw_plan(axes: Axes, count: np.ndarray, bounds: CylindricalGrid) -> AxesImage:
    """The polar cells as seen from above, drawn on a fine raster."""
    steps = np.linspace(-bounds.radius, bounds.radius, 361)
    x, y = np.meshgrid(steps, steps)
    flat = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1) + bounds.centre_xyz
    cells = bounds.indices(flat)
    inside = (cells >= 0).all(axis=1)
    picture = np.full(x.size, np.nan)
    picture[inside] = _nonzero(count)[cells[inside, 0], cells[inside, 1]]
    extent = (-bounds.radius, bounds.radius, -bounds.radius, bounds.radius)
    flat_picture = picture.reshape(x.shape)
    return axes.imshow(flat_picture, origin="lower", extent=extent, cmap="magma_r", vmin=0)


def _draw_rectangular(grid: OccupancyGrid, unit: str) -> Figure:
    figure = new_figure((11.0, 4.0))
    half = grid.grid.half_width  # pyright: ignore[reportAttributeAccessIssue]
    views = (("plan", 2, "xy"), ("front", 1, "xz"), ("side", 0, "yz"))
    for axes, (title, axis, names) in zip(figure.subplots(1, 3), views, strict=True):
        draw_projection(axes, grid.occupied, half, axis, names, unit)
        axes.set_title(title)
    return figure


def _nonzero(count: np.ndarray) -> np.ndarray:
    """Counts; empty cells are NaN, which is drawn white."""
    return np.where(count > 0, count, np.nan)


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
        margin: See `GridSpec`.

    Raises:
        InputError: The margin is out of range.
        GeometryError: The cloud spans no grid.
    """
    found: dict[str, list[OccupancyGrid]] = {}
    for kind in ("cylindrical", "rectangular"):
        input_spec = GridSpec(kind=kind, shape=shape, margin=margin)
        bounds = input_spec.bounds(cloud)
        points = input_spec.surface(cloud).points_xyz
        grids = []
        for turn in turns_deg:
            turned = Rotation.from_euler("z", turn, degrees=True)
            centre = bounds.centre_xyz
            grids.append(bounds.hits(turned.apply(points - centre) + centre))
        found[kind] = grids
    return found


def changed_share(first: OccupancyGrid, other: OccupancyGrid, turn_deg: float) -> float:
    """Fraction of the cells occupied in either of two grids that differ.

    A cylindrical grid is first rolled back by whole cells, which removes whole-cell turns exactly.
    """
    back = other.occupied
    if isinstance(other.grid, CylindricalGrid):
        cells = other.grid.shape[1]
        back = np.roll(back, -round(turn_deg / 360.0 * cells), axis=1)
    either = first.occupied | back
    return float((first.occupied ^ back).sum() / max(1, either.sum()))


def draw_turning(grids: dict[str, list[OccupancyGrid]], turns_deg: Sequence[float]) -> Figure:
    """Cylindrical grids unrolled over azimuth (top row), rectangular ones from above (bottom row).

    Args:
        grids: Result of `turned_grids`.
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
            bounds.outermost(cylindrical).T, origin="lower", extent=extent, aspect="auto",
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
