"""A picture of one grid."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.evaluation.figure_canvas import new_figure
from circumspect.grid import CylindricalGrid, OccupancyGrid

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
    surface = outermost_surface(grid)
    extent = (0.0, 360.0, -bounds.half_height, bounds.half_height)
    shown = wide.imshow(
        surface.T, origin="lower", extent=extent, aspect="auto", cmap="viridis", vmin=0
    )
    figure.colorbar(shown, ax=wide, label=f"outermost radius [{unit}]")
    wide.set(xlabel="azimuth [°]", ylabel=f"height [{unit}]", title="outermost surface, unrolled")
    wide.set_xticks(range(0, 361, 90))
    shown = _draw_plan(plan, occupied.sum(axis=2), bounds)
    plan.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]", title="plan")
    figure.colorbar(shown, ax=plan, label="cells over height", shrink=0.8)
    count = occupied.sum(axis=1)
    extent = (0.0, bounds.radius, -bounds.half_height, bounds.half_height)
    shown = profile.imshow(
        _nonzero(count).T, origin="lower", extent=extent, cmap="magma_r", vmin=0, vmax=azimuths
    )
    figure.colorbar(shown, ax=profile, label="cells over azimuth")
    profile.set(xlabel=f"radius [{unit}]", ylabel=f"height [{unit}]", title="profile")
    return figure


def outermost_surface(grid: OccupancyGrid) -> NDArray[np.float64]:
    """(azimuth, height) radius of the outermost occupied cell [m], NaN where there is none."""
    bounds, occupied = grid.grid, grid.occupied
    assert isinstance(bounds, CylindricalGrid)
    radii = bounds.shape[0]
    outermost = (radii - occupied[::-1].argmax(axis=0)) * (bounds.radius / radii)
    return np.where(occupied.any(axis=0), outermost, np.nan)


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
    views = (("plan", 2, "x", "y"), ("front", 1, "x", "z"), ("side", 0, "y", "z"))
    for axes, (title, axis, across, up) in zip(figure.subplots(1, 3), views, strict=True):
        shown = axes.imshow(
            _nonzero(grid.occupied.sum(axis=axis)).T,
            origin="lower",
            extent=(-half, half, -half, half),
            cmap="magma_r",
            vmin=0,
        )
        figure.colorbar(shown, ax=axes, label="occupied cells", shrink=0.8)
        axes.set(xlabel=f"{across} [{unit}]", ylabel=f"{up} [{unit}]", title=title)
    return figure


def _nonzero(count: np.ndarray) -> np.ndarray:
    """Counts with NaN, which is drawn white, where nothing is."""
    return np.where(count > 0, count, np.nan)
