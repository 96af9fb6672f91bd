"""An orthographic picture of a mesh, drawn in software with a depth buffer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import TriangleMesh

_AZIMUTH, _ELEVATION = np.radians(-132.0), np.radians(24.0)
"""Position of the viewer: in front of -x or -y, a little above."""
_LIGHT = np.array([-0.52, -0.22, 0.82])
_AMBIENT, _DIFFUSE = 0.42, 0.68
_LINE = 0.55
"""Brightness factor of pixels on a line."""


def shaded(
    mesh: TriangleMesh, pixels: int = 150, colour: Sequence[float] = (0.55, 0.70, 0.90)
) -> NDArray[np.float64]:
    """A picture of one mesh that just fills it, on white.

    Args:
        mesh: What to draw, z up.
        pixels: Side of the square picture.
        colour: Red, green, blue in 0 to 1.

    Returns:
        (pixels, pixels, 3) in 0 to 1.
    """
    fine = 3 * pixels
    corners = _projected(mesh.corners_xyz, fine)
    depth, face = _rasterised(corners, fine)
    light = _brightness(mesh)
    picture = np.ones((fine, fine, 3))
    seen = face >= 0
    picture[seen] = light[face[seen], None] * np.asarray(colour)
    picture[_lines(depth, face, mesh)] *= _LINE
    smooth = picture.clip(0.0, 1.0).reshape(pixels, 3, pixels, 3, 3)
    return smooth.mean(axis=(1, 3))


def _axes() -> NDArray[np.float64]:
    """(3, 3): its rows point to the right, up and towards the viewer."""
    ca, sa = np.cos(_AZIMUTH), np.sin(_AZIMUTH)
    ce, se = np.cos(_ELEVATION), np.sin(_ELEVATION)
    towards = np.array([ca * ce, sa * ce, se])
    right = np.array([-sa, ca, 0.0])
    return np.stack([right, np.cross(towards, right), towards])


def _projected(corners_xyz: NDArray[np.float64], pixels: int) -> NDArray[np.float64]:
    """(f, 3, 3): column, row and nearness of all corners, in pixels."""
    seen = corners_xyz @ _axes().T
    low, high = seen.min(axis=(0, 1)), seen.max(axis=(0, 1))
    scale = 0.92 * pixels / (high - low)[:2].max()
    centred = (seen - (low + high) / 2) * scale
    return centred * (1.0, -1.0, 1.0) + (pixels / 2, pixels / 2, 0.0)


def _rasterised(
    corners: NDArray[np.float64], pixels: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Nearness and index of the face seen at each pixel; -inf and -1 where there is none."""
    depth = np.full((pixels, pixels), -np.inf)
    face = np.full((pixels, pixels), -1, dtype=np.int64)
    lows = np.floor(corners[:, :, :2].min(axis=1)).astype(int).clip(min=0)
    highs = np.ceil(corners[:, :, :2].max(axis=1)).astype(int).clip(max=pixels) + 1
    edges = corners[:, 1:, :2] - corners[:, :1, :2]
    twice_area = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    rises = corners[:, 1:, 2] - corners[:, :1, 2]
    for k in np.flatnonzero(np.abs(twice_area) > 1e-9):
        (c0, r0), (c1, r1) = lows[k], highs[k]
        x = np.arange(c0, min(c1, pixels)) + 0.5 - corners[k, 0, 0]
        y = (np.arange(r0, min(r1, pixels)) + 0.5 - corners[k, 0, 1])[:, None]
        (e1x, e1y), (e2x, e2y) = edges[k]
        u = (x * e2y - y * e2x) / twice_area[k]
        v = (y * e1x - x * e1y) / twice_area[k]
        near = corners[k, 0, 2] + u * rises[k, 0] + v * rises[k, 1]
        window = (slice(r0, r1), slice(c0, c1))
        wins = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (near > depth[window])
        depth[window][wins] = near[wins]
        face[window][wins] = k
    return depth, face


def _normals(mesh: TriangleMesh) -> NDArray[np.float64]:
    """(f, 3) unit normals, turned towards the viewer: both sides of a face look alike."""
    a, b, c = np.moveaxis(mesh.corners_xyz, 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-300
    return normals * np.where(normals @ _axes()[2] < 0, -1.0, 1.0)[:, None]


def _brightness(mesh: TriangleMesh) -> NDArray[np.float64]:
    """(f,) Lambert's law, with some light from everywhere."""
    return _AMBIENT + _DIFFUSE * np.maximum(_normals(mesh) @ _LIGHT, 0.0)


def _lines(
    depth: NDArray[np.float64], face: NDArray[np.int64], mesh: TriangleMesh
) -> NDArray[np.bool_]:
    """Pixels on silhouettes and creases, so that parts of one colour stay apart."""
    jump = 0.025 * len(depth)
    normals = np.concatenate([_normals(mesh), np.zeros((1, 3))])[face]
    solid = np.where(face >= 0, depth, -1e9)
    marked = np.zeros(face.shape, dtype=bool)
    for axis in (0, 1):
        for step in (1, -1):
            falls = solid - np.roll(solid, step, axis) > jump
            bends = (normals * np.roll(normals, step, axis)).sum(axis=2) < 0.8
            # Of two pixels beside a crease only one is marked, which keeps the line thin.
            marked |= falls | (bends & (step == 1) & (np.roll(face, step, axis) >= 0))
    return marked & (face >= 0)
