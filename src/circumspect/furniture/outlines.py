"""Closed outlines in the plane, counter-clockwise, centred on the origin."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Outline = NDArray[np.float64]
"""(n, 2) [m] corners in counter-clockwise order; the last joins the first."""


def rectangle(width: float, depth: float) -> Outline:
    """A rectangle, (4, 2)."""
    return np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * (width / 2, depth / 2)


def ellipse(width: float, depth: float, corners: int = 32) -> Outline:
    """An ellipse with the given diameters, (corners, 2)."""
    angles = np.arange(corners) * (2 * np.pi / corners)
    return np.stack([np.cos(angles) * width / 2, np.sin(angles) * depth / 2], axis=1)


def superellipse(width: float, depth: float, power: float, corners: int = 32) -> Outline:
    """Between an ellipse (power 2) and a rectangle (power towards infinity), (corners, 2)."""
    angles = np.arange(corners) * (2 * np.pi / corners)
    cosine, sine = np.cos(angles), np.sin(angles)
    x = np.sign(cosine) * np.abs(cosine) ** (2 / power)
    y = np.sign(sine) * np.abs(sine) ** (2 / power)
    return np.stack([x * width / 2, y * depth / 2], axis=1)


def rounded_rectangle(width: float, depth: float, radius: float, steps: int = 4) -> Outline:
    """A rectangle with round corners, (4 * (steps + 1), 2).

    Args:
        width: Extent along x [m].
        depth: Extent along y [m].
        radius: Of the corners [m]; cut to half of the shorter side.
        steps: Edges a corner.
    """
    radius = min(radius, width / 2, depth / 2)
    # A trace of straight edge stays, so that a stadium or a disc has no doubled corner.
    radius *= 0.999
    turn = np.linspace(0.0, np.pi / 2, steps + 1)
    centres = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    centres = centres * (width / 2 - radius, depth / 2 - radius)
    angles = turn[None] + np.arange(4)[:, None] * np.pi / 2
    arcs = np.stack([np.cos(angles), np.sin(angles)], axis=-1) * radius
    return (centres[:, None] + arcs).reshape(-1, 2)


def regular(sides: int, width: float) -> Outline:
    """A regular polygon whose first edge faces -y; a square of the given width for 4 sides.

    Args:
        sides: Number of corners, at least 3.
        width: Distance between opposite edges of the polygon (its inner diameter) [m].
    """
    angles = -np.pi / 2 + (np.arange(sides) + 0.5) * (2 * np.pi / sides)
    radius = width / 2 / np.cos(np.pi / sides)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) * radius


def egg(width: float, length: float, taper: float, corners: int = 32) -> Outline:
    """An ellipse along y that is narrower towards -y.

    Args:
        width: Largest extent along x [m].
        length: Extent along y [m].
        taper: Share of the width lost at the narrow end, 0 (an ellipse) to 0.5.
        corners: Number of corners.
    """
    outline = ellipse(width, length, corners)
    along = outline[:, 1] / length
    return outline * np.stack([1 + taper * (along - 0.5) * 0.8, np.ones(corners)], axis=1)


def rounded_polygon(corners: ArrayLike, radius: float, steps: int = 5) -> Outline:
    """A polygon with round corners.

    Args:
        corners: (k, 2) [m] counter-clockwise.
        radius: Distance from a corner at which its bend begins [m]; cut to 0.45 of the
            shorter edge there.
        steps: Edges a bend.

    Returns:
        (k * (steps + 1), 2) [m].
    """
    points = np.asarray(corners, dtype=np.float64)
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    triples = zip(before, points, after, strict=True)
    return np.concatenate([bend(*triple, radius, steps) for triple in triples])


def bend(
    before: NDArray[np.float64],
    corner: NDArray[np.float64],
    after: NDArray[np.float64],
    radius: float,
    steps: int,
) -> NDArray[np.float64]:
    """The curve that replaces a corner, in the plane or in space.

    Args:
        before: (d,) [m] the point before the corner.
        corner: (d,) [m].
        after: (d,) [m] the point after it.
        radius: Distance from the corner at which the curve begins [m]; cut to 0.45 of the
            shorter edge.
        steps: Edges of the curve.

    Returns:
        (steps + 1, d) [m].
    """
    back, ahead = before - corner, after - corner
    lengths = np.linalg.norm(back), np.linalg.norm(ahead)
    reach = min(radius, 0.45 * float(min(lengths)))
    start, stop = corner + back / lengths[0] * reach, corner + ahead / lengths[1] * reach
    shares = np.linspace(0.0, 1.0, steps + 1)[:, None]
    return (1 - shares) ** 2 * start + 2 * shares * (1 - shares) * corner + shares**2 * stop


def resampled(outline: Outline, corners: int) -> Outline:
    """The outline with `corners` points at equal distances along it."""
    closed = np.concatenate([outline, outline[:1]])
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    wanted = np.arange(corners) * (travelled[-1] / corners)
    return np.stack([np.interp(wanted, travelled, column) for column in closed.T], axis=1)


def refined(outline: Outline, longest: float) -> Outline:
    """The outline with its edges cut into equal pieces of at most `longest` [m]."""
    pieces = []
    for here, after in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        count = max(1, int(np.ceil(np.linalg.norm(after - here) / longest)))
        pieces.append(here + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (after - here))
    return np.concatenate(pieces)
