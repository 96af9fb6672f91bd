"""Colour maps of the dashboard."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

HEIGHT, FRAMES, NORMAL, EVIDENCE = (
    "height",
    "frames that saw it",
    "surface normal",
    "class evidence",
)
COLOURINGS = (HEIGHT, FRAMES, NORMAL, EVIDENCE)

# Anchors from dark to light, with equal steps in lightness.
_SEQUENTIAL = np.array(
    [[53, 28, 92], [53, 76, 134], [33, 119, 139], [30, 159, 128], [98, 195, 93], [196, 218, 62],
     [250, 231, 61]], np.float64,
)  # fmt: skip
_DEPTH = np.array(
    [[250, 236, 120], [250, 170, 70], [226, 98, 82], [170, 51, 116], [100, 32, 122], [34, 20, 76]],
    np.float64,
)
_AGAINST, _NEUTRAL, _FOR = np.array([[37, 99, 190], [214, 214, 210], [202, 44, 34]], np.float64)
EVIDENCE_GROUPS = 9
"""Number of colours for the evidence of cells."""
NOTHING_MEASURED = (236, 239, 243)

PATH, ODOMETRY, TARGET = (194, 65, 12), (124, 58, 237), (29, 78, 216)
"""RGB of the camera and its path, the path by odometry alone, and the next view."""

CLASSES = np.array(
    [[29, 78, 216], [194, 65, 12], [21, 128, 61], [124, 58, 237], [14, 116, 144], [190, 24, 93],
     [161, 98, 7], [71, 85, 105], [225, 150, 40], [90, 180, 120]], np.uint8,
)  # fmt: skip
"""(10, 3) RGB of classes; further classes repeat them."""


def sequential(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    """(n, 3) RGB of values (n,), from dark for the smallest to light for the largest."""
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    return _between(_SEQUENTIAL, values, low, max(high - low, 1e-9))


def directions(normals_xyz: NDArray[np.floating]) -> NDArray[np.uint8]:
    """(n, 3) RGB of normals: x, y, z from -1 to 1 as red, green, blue."""
    return np.clip(127.5 + 127.5 * normals_xyz, 0, 255).astype(np.uint8)


def signed(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    """(n, 3) RGB of values (n,): red if positive, blue if negative, grey at 0."""
    largest = float(np.abs(values).max()) if len(values) else 0.0
    shares = np.clip(values / max(largest, 1e-12), -1, 1)[:, None]
    towards = np.where(shares > 0, _FOR, _AGAINST)
    return (_NEUTRAL + np.abs(shares) * (towards - _NEUTRAL)).astype(np.uint8)


def in_groups(
    values: NDArray[np.floating],
) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
    """Quantise evidence to a few colours.

    Args:
        values: (n,) evidence; positive supports the answer.

    Returns:
        (n,) group of each value, and (EVIDENCE_GROUPS, 3) RGB of the groups.
    """
    half = EVIDENCE_GROUPS // 2
    largest = float(np.abs(values).max()) if len(values) else 0.0
    groups = np.rint(half * values / max(largest, 1e-12)).astype(np.int64) + half
    return groups, signed(np.arange(-half, half + 1, dtype=np.float64))


def depth_picture(depth: NDArray[np.floating]) -> NDArray[np.uint8]:
    """(height, width, 3) RGB of a depth image [m]: near is light, missing is nearly white."""
    picture = np.empty((*depth.shape, 3), np.uint8)
    known = np.isfinite(depth)
    picture[~known] = NOTHING_MEASURED
    if known.any():
        low, high = np.percentile(depth[known], [1, 99])
        picture[known] = _between(_DEPTH, depth[known], low, max(high - low, 1e-3))
    return picture


def linear(colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    """(3,) colour to set for viser's lines, so that the screen shows an sRGB colour."""
    return np.rint(255 * (np.array(colour) / 255) ** 2.2).astype(np.uint8)


def pale(colour: NDArray[np.floating]) -> tuple[int, int, int]:
    """RGB halfway between a colour, 0 … 1, and light grey, for the surroundings."""
    red, green, blue = np.rint(127.5 * (np.asarray(colour) + 0.85)).astype(int).tolist()
    return red, green, blue


def _between(
    anchors: NDArray[np.float64], values: NDArray[np.floating], low: float, span: float
) -> NDArray[np.uint8]:
    steps = (np.asarray(values, np.float32) - np.float32(low)) * np.float32(255 / span)
    return _table(anchors)[np.clip(steps, 0, 255).astype(np.uint8)]


def _table(anchors: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(256, 3) colours interpolated between anchors."""
    places = np.linspace(0, len(anchors) - 1, 256)
    columns = [np.interp(places, np.arange(len(anchors)), column) for column in anchors.T]
    return np.rint(np.column_stack(columns)).astype(np.uint8)
