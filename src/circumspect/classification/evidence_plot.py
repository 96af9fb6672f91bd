"""Draws the evidence of a grid's cells: red speaks for the class, blue against it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from circumspect.grid import CylindricalGrid, OccupancyGrid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PLACES = (-1.0, -0.5, 0.0, 0.5, 1.0)
_COLOURS = np.array(
    [(20, 60, 150), (95, 150, 215), (222, 222, 220), (235, 130, 75), (165, 15, 25)], float
)
PERCENTILE = 99.0
"""Of the strengths that the full colours stand for: single cells may lie beyond."""


def evidence_span(values: NDArray[np.floating]) -> float:
    """The strength that the full colours stand for, never 0.

    Args:
        values: Evidence of any shape.
    """
    strengths = np.abs(values[values != 0])
    return float(np.percentile(strengths, PERCENTILE)) if strengths.size else 1.0


def evidence_colours(values: NDArray[np.floating], span: float) -> NDArray[np.uint8]:
    """The colour of each value.

    Args:
        values: Evidence of any shape.
        span: From -span to span the colours change, beyond they stay.

    Returns:
        (*shape, 3) uint8 red, green, blue.
    """
    scaled = np.clip(np.asarray(values, float) / span, -1.0, 1.0)
    channels = [np.interp(scaled, _PLACES, _COLOURS[:, channel]) for channel in range(3)]
    return np.rint(np.stack(channels, axis=-1)).astype(np.uint8)


def draw_evidence_grid(
    axes: Axes, cells: NDArray[np.float32], grid: OccupancyGrid, unit: str = "m"
) -> None:
    """The grid unrolled, of a box its front: along each line of sight the strongest cell.

    Args:
        axes: Where to draw.
        cells: Evidence of the grid's shape; red speaks for the class, blue against it.
        grid: What was shown.
        unit: Of the grid's bounds, as the axes name it.
    """
    bounds, span = grid.grid, evidence_span(cells)
    if isinstance(bounds, CylindricalGrid):
        extent = (0, 360, -bounds.half_height, bounds.half_height)
        draw_cells(axes, strongest(cells, grid, 0), span, extent, "auto")
        axes.set(xlabel="azimuth [°]", ylabel=f"height [{unit}]", title="grid, unrolled")
        axes.set_xticks(range(0, 361, 90))
        return
    half = bounds.half_width  # pyright: ignore[reportAttributeAccessIssue]
    draw_cells(axes, strongest(cells, grid, 1), span, (-half, half, -half, half), "equal")
    axes.set(xlabel=f"x [{unit}]", ylabel=f"z [{unit}]", title="grid, from the front")


def strongest(cells: NDArray[np.float32], grid: OccupancyGrid, axis: int) -> NDArray[np.float32]:
    """The evidence that is largest, for or against, along an axis; NaN where nothing is."""
    chosen = np.abs(cells).argmax(axis=axis)
    values = np.take_along_axis(cells, np.expand_dims(chosen, axis), axis).squeeze(axis)
    return np.where(grid.occupied.any(axis=axis), values, np.float32(np.nan))


def draw_cells(
    axes: Axes,
    values: NDArray[np.float32],
    span: float,
    extent: tuple[float, float, float, float],
    aspect: Literal["auto", "equal"],
) -> None:
    """A picture of evidence; white where it is NaN.

    Args:
        axes: Where to draw.
        values: (columns, rows) evidence.
        span: Of the colours, see `evidence_colours`.
        extent: Of the picture on the axes: left, right, bottom, top.
        aspect: Of its cells.
    """
    picture = evidence_colours(np.nan_to_num(values), span)
    picture[np.isnan(values)] = 255
    rows = picture.transpose(1, 0, 2)
    axes.imshow(rows, origin="lower", extent=extent, aspect=aspect, interpolation="nearest")
