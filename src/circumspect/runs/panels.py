"""The panels of a run's picture; each draws one thing into given axes."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.answer_text import percent
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, OccupancyGrid
from circumspect.recognition import FrameOutcome, RecognitionResult
from circumspect.runs.camera_path import camera_path
from circumspect.runs.run_path import RunPath

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK = "0.25"
CLASS_COLOURS = ("#1d4ed8", "#c2410c", "#15803d", "#7c3aed", "#0e7490")
LIGHT = np.array([-0.35, -0.55, 0.76])
MAX_POINTS = 40_000
MARGIN_ROWS = 2
"""Rows of the grid that are shown below and above the object."""
MIN_PATH_M = 0.05
"""A camera that moved less stood still [m]."""


def draw_side(
    axes: Axes, cloud: PointCloud, name: str, azimuth_deg: float, elevation_deg: float
) -> None:
    """The model as seen from far away, lit from the upper left.

    Args:
        axes: Where to draw.
        cloud: The model.
        name: Title.
        azimuth_deg: Where the eye is, seen from the model.
        elevation_deg: The same, above the horizon.
    """
    cloud = thinned(cloud)
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    towards = level * np.cos(elevation) + np.array([0.0, 0.0, np.sin(elevation)])
    up = np.cross(towards, right)
    points = cloud.points_xyz - cloud.points_xyz.mean(axis=0)
    facing = np.ones(len(points), bool)
    shade = np.full(len(points), 0.7)
    if cloud.normals_xyz is not None:
        light = LIGHT[0] * right + LIGHT[2] * up - LIGHT[1] * towards
        facing = cloud.normals_xyz @ towards > -0.05
        shade = 0.25 + 0.7 * np.clip(cloud.normals_xyz @ light, 0, 1)
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
    axes.set_title(f"Model, from {name}", loc="left", color=INK)
    _draw_scale(axes, centre[0] - half, centre[1] - half, size)


def _draw_scale(axes: Axes, x: float, y: float, size: float) -> None:
    """A bar of a round length below the model."""
    bar = _round_length(size / 3)
    axes.plot([x, x + bar], [y, y], color=INK, lw=2.5, clip_on=False)
    axes.text(x + bar / 2, y - 0.015 * size, f"{bar:g} m", ha="center", va="top", color=INK)


def draw_grid(axes: Axes, grid: OccupancyGrid) -> None:
    """The grid unrolled: outermost occupied radius over azimuth and height; white is free."""
    bounds = grid.grid
    if not isinstance(bounds, CylindricalGrid):
        axes.text(0.5, 0.5, "not a cylindrical grid", ha="center", transform=axes.transAxes)
        return
    from matplotlib.colors import ListedColormap

    rings = (np.arange(bounds.shape[0]) + 1)[:, None, None] * (bounds.radius / bounds.shape[0])
    outermost = np.where(grid.occupied, rings, 0).max(axis=0)
    floor = bounds.centre_xyz[2]
    first = np.degrees(bounds.azimuth_offset)
    extent = (first, first + 360, floor - bounds.half_height, floor + bounds.half_height)
    seen_free = (grid.occupied | grid.free).any(axis=0)
    shown = {"origin": "lower", "extent": extent, "aspect": "auto", "interpolation": "nearest"}
    axes.imshow(seen_free.T, cmap=ListedColormap(["#d4d4d4", "white"]), vmin=0, vmax=1, **shown)
    heat = axes.imshow(
        np.ma.masked_equal(outermost, 0).T, cmap="magma_r", vmin=0, vmax=bounds.radius, **shown
    )
    axes.set_xticks(np.arange(0, 361, 90))
    axes.set(xlabel="azimuth [°] from +x", ylabel="height z [m]")
    axes.set_ylim(_shown_heights(grid, extent))
    axes.set_title("Grid, unrolled (grey: never seen, white: free)", loc="left", color=INK)
    bar = axes.figure.colorbar(heat, ax=axes, pad=0.015, aspect=18)
    bar.set_label("outermost radius [m]")


def _shown_heights(
    grid: OccupancyGrid, extent: tuple[float, float, float, float]
) -> tuple[float, float]:
    """From where to where there is an object [m], and a little more; the grid's where it is bare.

    The grid is as high as it is wide, and most things are not.
    """
    low, high = extent[2:]
    rows = np.flatnonzero(grid.occupied.any(axis=(0, 1)))
    if len(rows) == 0:
        return low, high
    row = (high - low) / grid.occupied.shape[2]
    bottom, top = low + row * rows[0], low + row * (rows[-1] + 1)
    return max(low, float(bottom) - MARGIN_ROWS * row), min(high, float(top) + MARGIN_ROWS * row)


def draw_probabilities(
    axes: Axes, result: RecognitionResult, run_path: RunPath, most: int = 4
) -> None:
    """Probability of the leading classes over what was driven.

    Frames that were not used are marked at the bottom. Where nothing was named no curve is drawn.
    """
    along, what = _progress(result, run_path)
    _draw_curves(axes, result, along, most)
    unused = [step.index for step in result.steps if step.outcome != FrameOutcome.CLASSIFIED]
    if unused:
        axes.plot(along[unused], np.full(len(unused), -0.05), "|", color="#b91c1c", ms=7)
        axes.text(
            0.0, 1.015, "| frame not used", color="#b91c1c",
            transform=axes.transAxes, fontsize=9.5,
        )  # fmt: skip
    spare = 0.01 * float(np.ptp(along)) or 0.5
    axes.set(
        xlim=(along.min() - spare, along.max() + spare), ylim=(-0.09, 1.03), xlabel=what,
        ylabel="probability [%]",
    )  # fmt: skip
    shares = np.linspace(0, 1, 6)
    axes.set_yticks(shares, [f"{100 * share:.0f}" for share in shares])
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="0.9")
    # Above the note, which would hide curves within the axes.
    axes.set_title("Answer on the way", loc="left", color=INK, pad=20 if unused else None)


def _draw_curves(
    axes: Axes, result: RecognitionResult, along: NDArray[np.float64], most: int
) -> None:
    """A curve a class, the final answer's first."""
    answers = [
        (step.index, step.prediction) for step in result.steps if step.prediction is not None
    ]
    if not answers:
        axes.text(0.5, 0.5, "nothing was named", ha="center", transform=axes.transAxes, color=INK)
        return
    final = answers[-1][1]
    names = list(final.probabilities)
    table = np.array([[answer.probabilities[name] for name in names] for _, answer in answers])
    places = along[[index for index, _ in answers]]
    # The answer, then those that matter at the end, then those that mattered on the way.
    weights = table[-1] + 0.25 * table.mean(axis=0)
    weights[names.index(final.label)] = np.inf
    rank = np.argsort(-weights)[:most]
    ends = _spread_labels(table[-1, rank], 0.075)
    style = "-o" if len(answers) <= 60 else "-"
    for place, (index, colour) in enumerate(zip(rank, CLASS_COLOURS, strict=False)):
        axes.plot(
            places, table[:, index], style, color=colour, lw=2.4 if place == 0 else 1.5, ms=2.5
        )
        axes.annotate(
            f"{names[index].replace('_', ' ')} {percent(table[-1, index])}", (1.02, ends[place]),
            xycoords=("axes fraction", "data"), color=colour, va="center", annotation_clip=False,
            fontweight="bold" if place == 0 else "normal",
        )  # fmt: skip


def _progress(result: RecognitionResult, run_path: RunPath) -> tuple[NDArray[np.float64], str]:
    """(n,) progress of the run at each step, and its label."""
    stamps = np.array([step.stamp for step in result.steps])
    driven = run_path.driven_by(stamps)
    if driven is not None:
        return driven, "distance driven [m]"
    path = camera_path(result)
    if path is not None and len(path) > 1:
        steps = np.linalg.norm(np.diff(path.positions_xyz, axis=0), axis=1)
        if steps.sum() > MIN_PATH_M:
            far = np.interp(stamps, path.stamps, np.concatenate([[0.0], np.cumsum(steps)]))
            return far, "way of the camera [m]"
    return np.arange(1.0, len(stamps) + 1.0), "frame"


def thinned(cloud: PointCloud) -> PointCloud:
    """At most `MAX_POINTS` of the points, evenly picked."""
    step = -(-len(cloud) // MAX_POINTS)
    if step == 1:
        return cloud
    normals = None if cloud.normals_xyz is None else cloud.normals_xyz[::step]
    return PointCloud(cloud.points_xyz[::step], normals_xyz=normals)


def _round_length(length: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not longer."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step * power for step in (1, 2, 5) if step * power <= length))


def _spread_labels(heights: NDArray[np.floating], gap: float) -> NDArray[np.float64]:
    """Heights at least `gap` apart, as close to the wanted ones as a single sweep gets them."""
    order = np.argsort(heights)
    spread = np.array(heights, dtype=np.float64)
    for lower, upper in pairwise(order):
        spread[upper] = max(spread[upper], spread[lower] + gap)
    return spread
