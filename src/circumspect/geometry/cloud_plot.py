"""Draws a cloud of points as a lit surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.figure_canvas import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LIGHT = np.array([-0.35, -0.55, 0.76])


def draw_cloud(
    axes: Axes,
    points_xyz: NDArray[np.float64],
    normals_xyz: NDArray[np.float64] | None,
    azimuth_deg: float,
    elevation_deg: float,
) -> None:
    """A surface as seen from far away, lit from the upper left, with a bar as its scale.

    Args:
        axes: Where to draw.
        points_xyz: (n, 3) [m] the surface.
        normals_xyz: (n, 3) unit normals, to hide points that face away; None shows all.
        azimuth_deg: Where the eye is, seen from the object [degrees].
        elevation_deg: The same, above the horizon [degrees].
    """
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    towards = level * np.cos(elevation) + np.array([0.0, 0.0, np.sin(elevation)])
    up = np.cross(towards, right)
    points = points_xyz - points_xyz.mean(axis=0)
    facing = np.ones(len(points), bool)
    shade = np.full(len(points), 0.7)
    if normals_xyz is not None:
        light = LIGHT[0] * right + LIGHT[2] * up - LIGHT[1] * towards
        facing = normals_xyz @ towards > -0.05
        shade = 0.25 + 0.7 * np.clip(normals_xyz @ light, 0, 1)
    order = np.flatnonzero(facing)[np.argsort((points @ towards)[facing])]
    across, above = points @ right, points @ up
    size = float(max(np.ptp(across), np.ptp(above), 1e-6))
    axes.scatter(
        across[order], above[order], c=shade[order], s=(3.6 / size) ** 2 + 1,
        cmap="copper", vmin=0, vmax=1, linewidths=0,
    )  # fmt: skip
    axes.set_aspect("equal")
    axes.set_axis_off()
    half = 0.54 * size
    centre = ((across.max() + across.min()) / 2, (above.max() + above.min()) / 2)
    axes.set(xlim=(centre[0] - half, centre[0] + half), ylim=(centre[1] - half, centre[1] + half))
    _draw_scale(axes, centre[0] - half, centre[1] - half, size)


def _draw_scale(axes: Axes, x: float, y: float, size: float) -> None:
    """A bar of a round length below the model."""
    bar = _round_length(size / 3)
    axes.plot([x, x + bar], [y, y], color=INK, lw=2.5, clip_on=False)
    axes.text(x + bar / 2, y - 0.015 * size, f"{bar:g} m", ha="center", va="top", color=INK)


def _round_length(length: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not longer."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step * power for step in (1, 2, 5) if step * power <= length))
