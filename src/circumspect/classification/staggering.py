"""Grids whose cells begin elsewhere in every direction, so that no answer hangs on where they do.

A flat top or side fills one layer of cells or the next by a millimetre's noise, all of it at once.
The further grids of an object are turned by fractions of an azimuth cell; staggered ones also begin
at other fractions of a cell in height and are of other sizes, spread evenly by an additive
recurrence (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

from circumspect.errors import InputError
from circumspect.grid import CylindricalGrid

PLASTIC = 1.324717957244746
"""The real root of x³ = x + 1."""
ROUNDING = 1e-12
"""A margin that is short by less is as good as enough."""
WIDEST = 2.0
"""Between the smallest and the largest grid the outermost border moves by less than so many cells,
one half way to the axis."""


def require_room(shape: Sequence[int], margin: float) -> None:
    """Check that each grid of an object holds all of it.

    Args:
        shape: Cells along (radius, azimuth, height).
        margin: How many times as large as the smallest one the first is.

    Raises:
        InputError: It does not.
    """
    rings, _, layers = shape
    room = (1.0 - WIDEST / 2 / rings) * (1.0 - 1.0 / layers)
    if not room > 0:
        raise InputError("grids of one ring or one layer can not be staggered")
    if not margin * room >= 1.0 - ROUNDING:
        raise InputError(
            f"staggered grids of these cells need a margin of {ceil(1e3 / room) / 1e3:g}, not "
            f"{margin:g}, lest the object stick out; circumspect export without --staggered makes "
            "a classifier that needs none"
        )


def stagger(grid: CylindricalGrid, view: int) -> CylindricalGrid:
    """One of an object's grids.

    Args:
        grid: The one of view 0, or that turned.
        view: Which, from 0.

    Returns:
        The grid, moved by up to half a cell along the axis and of another size.
    """
    up, wider = ((view / PLASTIC**power + 0.5) % 1.0 - 0.5 for power in (1, 2))
    rings, _, layers = grid.shape
    size = 1.0 + WIDEST * wider / rings
    x, y, z = grid.centre_xyz
    half_height = size * grid.half_height
    return replace(
        grid,
        radius=size * grid.radius,
        half_height=half_height,
        centre_xyz=(x, y, z + up * 2.0 * half_height / layers),
    )
