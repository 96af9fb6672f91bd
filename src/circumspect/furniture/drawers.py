"""Carcasses: boxes of boards with drawers or doors, and their handles, in a front to -y."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.furniture.legs import handle
from circumspect.furniture.placement import both_sides, joined, moved
from circumspect.furniture.primitives import box, strip
from circumspect.geometry import TriangleMesh

HANDLES = ("knob", "bar", "bow", "none")


@dataclass(frozen=True)
class DrawerStyle:
    """Style of all fronts of one piece.

    Attributes:
        gap: between neighbouring fronts [m].
        proud: how far fronts stand out of the carcass [m].
        handle: one of `HANDLES`.
        growth: height of a row relative to the row below it.
        boxes: whether drawers are closed boxes that reach back into the carcass.
    """

    gap: float
    proud: float
    handle: str
    growth: float
    boxes: bool

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> DrawerStyle:
        """A style at random."""
        return cls(
            gap=rng.uniform(0.006, 0.025),
            proud=rng.uniform(0.004, 0.022),
            handle=str(rng.choice(HANDLES, p=[0.4, 0.2, 0.2, 0.2])),
            growth=float(rng.choice([1.0, rng.uniform(0.75, 0.95)])),
            boxes=rng.random() < 0.45,
        )


def carcass(
    rng: np.random.Generator,
    size: tuple[float, float, float],
    grid: tuple[int, int],
    style: DrawerStyle | None = None,
) -> TriangleMesh:
    """A chest on z = 0, its front at -y full of drawers.

    Args:
        rng: Draws the style where none is given, and details.
        size: (width, depth, height) [m].
        grid: (columns, rows) of drawers.
        style: Of the fronts.
    """
    width, depth, height = size
    style = style or DrawerStyle.drawn(rng)
    if not style.boxes:
        return joined([box(size), fronts(rng, (width, height), -depth / 2, grid, style)])
    board = rng.uniform(0.012, 0.025)
    walls = open_box(size, board)
    inner = (width - 2 * board, height - 2 * board)
    inside = fronts(rng, inner, -depth / 2 + style.proud, grid, style, depth - 3 * board)
    return joined([walls, moved(inside, (0.0, 0.0, board))])


def open_box(size: tuple[float, float, float], board: float, back: bool = True) -> TriangleMesh:
    """Two sides, a floor, a lid and perhaps a back, open to -y; on z = 0."""
    width, depth, height = size
    side = box((board, depth, height), ((width - board) / 2, 0.0, 0.0))
    flat = (width, depth, board)
    parts = [both_sides(side), box(flat), box(flat, (0.0, 0.0, height - board))]
    if back:
        parts.append(box((width, 0.5 * board, height), (0.0, depth / 2 - 0.25 * board, 0.0)))
    return joined(parts)


def fronts(
    rng: np.random.Generator,
    size: tuple[float, float],
    front: float,
    grid: tuple[int, int],
    style: DrawerStyle,
    deep: float = 0.0,
) -> TriangleMesh:
    """Rows and columns of drawers on a face that looks to -y.

    Args:
        rng: Draws details of handles.
        size: (width, height) of the face [m]; its lower edge is centred on the origin.
        front: y of the face [m].
        grid: (columns, rows).
        style: Of the fronts.
        deep: How far the drawers reach behind the face [m].
    """
    width, height = size
    columns, rows = grid
    cell = (width - style.gap) / columns
    shares = style.growth ** np.arange(rows)
    tall = shares / shares.sum() * (height - style.gap)
    bases = style.gap + np.concatenate([[0.0], np.cumsum(tall)[:-1]])
    places = (-0.26 * cell, 0.26 * cell) if cell > 0.5 and style.handle != "none" else (0.0,)
    parts = []
    for column in range(columns):
        x = -width / 2 + style.gap / 2 + cell * (column + 0.5)
        for base, high in zip(bases, tall, strict=True):
            thick = style.proud + deep
            drawer = (cell - style.gap, thick, high - style.gap)
            parts.append(box(drawer, (x, front - style.proud + thick / 2, base)))
            if style.handle == "none":
                continue
            level = base + 0.5 * (high - style.gap)
            for shift in places:
                middle = (x + shift, front - style.proud, level)
                parts.append(handle(rng, style.handle, middle, min(0.16, 0.35 * cell)))
    return joined(parts)


def doors(
    rng: np.random.Generator, size: tuple[float, float], front: float, style: DrawerStyle
) -> TriangleMesh:
    """Two doors, or one before a narrow carcass, with framed panels.

    Args:
        rng: Draws details.
        size: (width, height) of the face [m]; its lower edge is centred on the origin.
        front: y of the face [m].
        style: Of the fronts.
    """
    width, height = size
    count = 2 if width > 0.5 else 1
    cell = width / count
    rim = min(0.07, 0.16 * cell)
    parts = []
    for k in range(count):
        x = -width / 2 + cell * (k + 0.5)
        door = (cell - style.gap, style.proud, height - style.gap)
        parts.append(box(door, (x, front - style.proud / 2, style.gap / 2)))
        field = (door[0] - 2 * rim, 0.01, door[2] - 2 * rim)
        parts.append(box(field, (x, front - style.proud - 0.005, style.gap / 2 + rim)))
        towards_middle = 0.0 if count == 1 else (0.5 - k) * 2
        grip = (x + towards_middle * 0.4 * cell, front - style.proud, 0.5 * height)
        parts.append(handle(rng, "knob", grip, 0.1))
    return joined(parts)


def arched_plinth(width: float, depth: float, height: float, board: float) -> TriangleMesh:
    """A base of boards with arches cut out between its four corners, on z = 0."""
    parts = []
    for long, across, axis in ((width, depth, "y"), (depth, width, "x")):
        u = np.linspace(-long / 2, long / 2, 15)
        arch = height * 0.7 * np.clip(1.15 - np.abs(2 * u / long) ** 4 * 1.4, 0.0, 1.0)
        edge = across / 2
        parts.append(both_sides(strip(u, arch, height, edge - board, edge, axis), axis))
    return joined(parts)
