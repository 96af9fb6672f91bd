"""Bent sheets: surfaces of some thickness over a grid of points, and smooth paths for rods."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.furniture.outlines import bend
from circumspect.furniture.primitives import loft
from circumspect.geometry import TriangleMesh


def sheet(rows: ArrayLike, thickness: float) -> TriangleMesh:
    """A bent sheet: a moulded seat, a curved back.

    Args:
        rows: (m, n, 3) [m] points of its middle surface, m >= 2 rows of n >= 2.
        thickness: [m].
    """
    points = np.asarray(rows, dtype=np.float64)
    normals = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    half = normals * (thickness / 2)
    sides = np.concatenate([points - half, (points + half)[:, ::-1]], axis=1)
    # The first and the last row are closed by rings folded flat onto the middle surface.
    folded = np.concatenate([points, points[:, ::-1]], axis=1)
    return loft(np.concatenate([folded[:1], sides, folded[-1:]]), caps=False)


def shell(
    profile: ArrayLike, widths: ArrayLike, curls: ArrayLike, thickness: float
) -> TriangleMesh:
    """A sheet that follows a profile in the y-z plane, its sides curled up.

    Args:
        profile: (k, 2) [m] y and z of its middle line, from the front of a seat to the top of
            its back.
        widths: (k,) [m].
        curls: (k,) [m] how far its edges stand out of the sheet, to the side of the sitter.
        thickness: [m].
    """
    middle = np.asarray(profile, dtype=np.float64)
    along = np.gradient(middle, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    towards = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across = np.linspace(-1.0, 1.0, 11)
    lift = np.asarray(curls)[:, None] * np.abs(across) ** 2.5
    points = np.empty((len(middle), len(across), 3))
    points[..., 0] = np.asarray(widths)[:, None] / 2 * across
    points[..., 1:] = middle[:, None] + lift[..., None] * towards[:, None]
    return sheet(points, thickness)


def smooth_path(corners: ArrayLike, radius: float, steps: int = 4) -> NDArray[np.float64]:
    """A path through corners that are rounded off.

    Args:
        corners: (k, 3) [m], k >= 2.
        radius: Distance from a corner at which the bend begins [m]; cut to 0.45 of the
            shorter edge there.
        steps: Edges a bend.

    Returns:
        (2 + (k - 2) * (steps + 1), 3) [m].
    """
    points = np.asarray(corners, dtype=np.float64)
    triples = zip(points[:-2], points[1:-1], points[2:], strict=True)
    bends = [bend(*triple, radius, steps) for triple in triples]
    return np.concatenate([points[:1], *bends, points[-1:]])


def evenly_spaced(path: ArrayLike, count: int) -> NDArray[np.float64]:
    """`count` points at equal distances along a path (k, 3), its ends among them."""
    points = np.asarray(path, dtype=np.float64)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0.0, travelled[-1], count)
    return np.stack([np.interp(wanted, travelled, column) for column in points.T], axis=1)
