"""Inputs beside the cells of a grid: the object's size, and whether visibility is known.

A grid forgets the size of its object. The context states it in metres, from the occupied cells and
the bounds of the grid, so that it is the same for a cloud, a scan and a saved grid.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

VISIBILITY_KNOWN, SCALE_KNOWN, LOG_HEIGHT, LOG_RADIUS, LOG_MAJOR, LOG_MINOR = range(6)
"""Columns: two flags, 1 or 0, then natural logarithms of lengths in metres: height, largest radius
and the two principal standard deviations in the plane. Lengths are 0 where the scale is unknown."""
WIDTH = 6


def grid_context(
    occupied: NDArray[np.bool_], size: tuple[float, float] | None, *, visible: bool
) -> NDArray[np.float32]:
    """The context of one cylindrical grid.

    Args:
        occupied: (radius, azimuth, height) bool, at least one cell.
        size: Radius and half height of the grid [m]; None where the scale is unknown.
        visible: Whether free cells are marked, so that the others are unknown.

    Returns:
        (6,) float32.
    """
    context = np.zeros(WIDTH, np.float32)
    context[VISIBILITY_KNOWN] = visible
    if size is None or not occupied.any():
        return context
    radius, half_height = size
    rings, sectors, layers = occupied.shape
    cells = occupied.sum(axis=2)
    high = np.flatnonzero(occupied.any(axis=(0, 1)))
    height = (high[-1] - high[0] + 1) * 2.0 * half_height / layers
    r = (np.arange(rings) + 0.5) * radius / rings
    azimuth = (np.arange(sectors) + 0.5) * 2.0 * np.pi / sectors
    x, y = r[:, None] * np.cos(azimuth), r[:, None] * np.sin(azimuth)
    weights = cells * r[:, None]  # Cells grow with their radius.
    weights = weights / weights.sum()
    mean = (weights * x).sum(), (weights * y).sum()
    xx = (weights * (x - mean[0]) ** 2).sum()
    yy = (weights * (y - mean[1]) ** 2).sum()
    xy = (weights * (x - mean[0]) * (y - mean[1])).sum()
    middle, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    cell = radius / rings
    outer = (np.flatnonzero(cells.any(axis=1))[-1] + 1) * cell
    lengths = [
        height, outer,
        np.sqrt(middle + half), np.sqrt(max(middle - half, 0.0) + (cell / 4) ** 2),
    ]  # fmt: skip
    context[SCALE_KNOWN] = 1.0
    context[LOG_HEIGHT:] = np.log(np.maximum(lengths, 1e-4))
    return context


class TakesContext(Protocol):
    """Anything that says whether a network takes contexts, see `InputSpec`."""

    @property
    def takes_context(self) -> bool:
        """See `InputSpec.takes_context`."""
        ...

    def context(self, inputs: NDArray[Any]) -> NDArray[np.float32] | None:
        """See `InputSpec.context`."""
        ...


def contexts_of(
    input_spec: TakesContext, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
) -> NDArray[np.float32] | None:
    """The contexts of many objects: the given ones, or those of an unknown scale.

    Args:
        input_spec: How objects are shown.
        inputs: (n, views, *input_shape).
        contexts: (n, 6), or None.

    Returns:
        (n, 6) float32, or None where the network takes none.
    """
    if not input_spec.takes_context:
        return None
    if contexts is not None:
        return contexts.astype(np.float32, copy=False)
    made = [input_spec.context(one) for one in inputs]
    return np.array([one for one in made if one is not None], np.float32).reshape(-1, WIDTH)
