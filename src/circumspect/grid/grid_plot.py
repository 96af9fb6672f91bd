"""Draws the cells of a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.figure_canvas import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MARGIN_ROWS = 2
"""Rows of the grid that are shown below and above the object."""


def draw_unrolled(
    axes: Axes,
    radii: NDArray[np.float64],
    seen_free: NDArray[np.bool_],
    extent: tuple[float, float, float, float],
    largest: float,
    unit: str = "m",
) -> None:
    """Outermost occupied radius of a cylinder over azimuth and height.

    Args:
        axes: Where to draw.
        radii: (azimuth, height) outermost occupied radius [m], NaN where nothing is occupied.
        seen_free: (azimuth, height) False where no cell is known.
        extent: First and last azimuth [degrees], lowest and highest z [m].
        largest: Radius of the grid [m].
        unit: Of the lengths, as the axes name it.
    """
    from matplotlib.colors import ListedColormap

    shown = {"origin": "lower", "extent": extent, "aspect": "auto", "interpolation": "nearest"}
    axes.imshow(seen_free.T, cmap=ListedColormap(["#d4d4d4", "white"]), vmin=0, vmax=1, **shown)
    heat = axes.imshow(radii.T, cmap="magma_r", vmin=0, vmax=largest, **shown)
    axes.set_xticks(np.arange(0, 361, 90))
    axes.set(xlabel="azimuth [°] from +x", ylabel=f"height z [{unit}]")
    axes.set_ylim(_shown_heights(np.isfinite(radii), *extent[2:]))
    axes.set_title("Grid, unrolled (grey: unknown, white: free)", loc="left", color=INK)
    bar = axes.figure.colorbar(heat, ax=axes, pad=0.015, aspect=18)
    bar.set_label(f"outermost radius [{unit}]")


def draw_projection(
    axes: Axes,
    occupied: NDArray[np.bool_],
    half_width: float,
    axis: int = 2,
    names: str = "xy",
    unit: str = "m",
) -> None:
    """Occupied cells of a cube, counted along an axis.

    Args:
        axes: Where to draw.
        occupied: (x, y, z) cells.
        half_width: Of the cube [m].
        axis: Along which cells are counted.
        names: Of the two other axes.
        unit: Of the width, as the axes name it.
    """
    count = occupied.sum(axis=axis)
    extent = (-half_width, half_width, -half_width, half_width)
    shown = axes.imshow(
        np.where(count > 0, count, np.nan).T, origin="lower", extent=extent, cmap="magma_r", vmin=0
    )
    axes.figure.colorbar(shown, ax=axes, label="occupied cells", shrink=0.8)
    axes.set(xlabel=f"{names[0]} [{unit}]", ylabel=f"{names[1]} [{unit}]")


def _shown_heights(occupied: NDArray[np.bool_], low: float, high: float) -> tuple[float, float]:
    """From where to where there is an object [m], and a little more; the grid's where it is bare.

    The grid is as high as it is wide, and most things are not.
    """
    rows = np.flatnonzero(occupied.any(axis=0))
    if len(rows) == 0:
        return low, high
    row = (high - low) / occupied.shape[1]
    bottom, top = low + row * rows[0], low + row * (rows[-1] + 1)
    return max(low, float(bottom) - MARGIN_ROWS * row), min(high, float(top) + MARGIN_ROWS * row)
