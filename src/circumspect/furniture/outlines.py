"""Closed outlines in the plane, counter-clockwise, centred on the origin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
