"""The panels of a run's picture; each draws one thing into given axes."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, OccupancyGrid
from circumspect.pipeline.records import RecognitionResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PATH_COLOUR, START_COLOUR, INK = "#c2410c", "#15803d", "0.25"
CLASS_COLOURS = ("#1d4ed8", "#c2410c", "#15803d", "#7c3aed", "#0e7490")
LIGHT = np.array([-0.35, -0.55, 0.76])
MOST_POINTS = 40_000


def draw_plan(axes: Axes, cloud: PointCloud, result: RecognitionResult) -> None:
    """Plan view: the object, the camera's path, where it started and where it looked."""
    points = _thinned(cloud).points_xyz
    shades = axes.scatter(
        points[:, 0], points[:, 1], c=points[:, 2], s=1.0, cmap="viridis", linewidths=0, zorder=2
    )
    poses = [step.pose.T_map_camera for step in result.steps if step.pose is not None]
    places = np.array([pose.translation[:2] for pose in poses])
    looks = np.array([pose.rotation.as_matrix()[:2, 2] for pose in poses])
    lengths = np.linalg.norm(looks, axis=1, keepdims=True)
    looks = looks / np.maximum(lengths, 1e-9)
    axes.plot(*places.T, "-", color=PATH_COLOUR, lw=1.2, zorder=1)
    every = max(1, len(places) // 24)
    axes.quiver(
        *places[::every].T, *looks[::every].T, color=PATH_COLOUR, width=0.006,
        scale=4.5, scale_units="inches", units="width", headwidth=4.5, zorder=3,
    )  # fmt: skip
    axes.plot(*places[0], "o", color=START_COLOUR, ms=10, mec="white", mew=1.5, zorder=4)
    outward = places[0] - points[:, :2].mean(axis=0)
    axes.annotate(
        "start", places[0], xytext=14 * outward / max(float(np.linalg.norm(outward)), 1e-9),
        textcoords="offset points", color=START_COLOUR, fontweight="bold", ha="center",
        va="center", zorder=4,
    )  # fmt: skip
    everything = np.concatenate([places, points[:, :2]])
    middle = (everything.max(axis=0) + everything.min(axis=0)) / 2
    half = 0.56 * float(np.ptp(everything, axis=0).max()) + 0.1
    axes.set(
        xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half),
        aspect="equal", xlabel="x [m]", ylabel="y [m]",
    )  # fmt: skip
    axes.set_title("Plan view: path, start, camera directions", loc="left", color=INK)
    bar = axes.figure.colorbar(shades, ax=axes, shrink=0.75, pad=0.02, aspect=25)
    bar.set_label("height z [m]")


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
    cloud = _thinned(cloud)
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
    axes.set_title(f"Model, seen from {name}", loc="left", color=INK)
    _draw_scale(axes, centre[0] - half, centre[1] - half, size)


def _draw_scale(axes: Axes, x: float, y: float, size: float) -> None:
    """A bar of a round length below the model."""
    bar = _round_length(size / 3)
    axes.plot([x, x + bar], [y, y], color=INK, lw=2.5, clip_on=False)
    axes.text(x + bar / 2, y - 0.015 * size, f"{bar:g} m", ha="center", va="top", color=INK)


def draw_grid(axes: Axes, grid: OccupancyGrid) -> None:
    """The grid unrolled: outermost occupied radius over azimuth and height."""
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
    axes.set_xticks(np.arange(0, 361, 45))
    axes.set(xlabel="azimuth [°], counter-clockwise from +x", ylabel="height z [m]")
    cells = " x ".join(str(n) for n in bounds.shape)
    axes.set_title(
        f"Grid of {cells}, unrolled (white: seen free, grey: never seen)", loc="left", color=INK
    )
    bar = axes.figure.colorbar(heat, ax=axes, pad=0.015, aspect=18)
    bar.set_label("outermost radius [m]")


def draw_probabilities(axes: Axes, result: RecognitionResult, most: int = 4) -> None:
    """Probability of the leading classes after each frame."""
    from matplotlib.ticker import MaxNLocator

    told = [step for step in result.steps if step.prediction is not None]
    frames = np.array([step.index + 1 for step in told])
    names = list(told[-1].prediction.probabilities) if told and told[-1].prediction else []
    table = np.array(
        [[step.prediction.probabilities[n] for n in names] for step in told if step.prediction]
    )
    # Those that matter at the end come first, then those that mattered on the way.
    rank = np.argsort(-(table[-1] + 0.25 * table.mean(axis=0)))[:most]
    ends = _spread_labels(table[-1, rank], 0.075)
    for place, (index, colour) in enumerate(zip(rank, CLASS_COLOURS, strict=False)):
        axes.plot(
            frames, table[:, index], "-o", color=colour, lw=2.4 if place == 0 else 1.5, ms=2.5
        )
        axes.annotate(
            f"{names[index].replace('_', ' ')} {table[-1, index]:.2f}", (1.015, ends[place]),
            xycoords=("axes fraction", "data"), color=colour, va="center", annotation_clip=False,
            fontweight="bold" if place == 0 else "normal",
        )  # fmt: skip
    axes.set(
        xlim=(frames[0] - 0.5, frames[-1] + 0.5),
        ylim=(-0.03, 1.03),
        xlabel="frame",
        ylabel="probability",
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    box = axes.get_position()
    axes.set_position((box.x0, box.y0, box.width * 0.8, box.height))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="0.9")
    axes.set_title("Answer after each frame", loc="left", color=INK)


def _thinned(cloud: PointCloud) -> PointCloud:
    """At most `MOST_POINTS` of the points, evenly picked."""
    step = -(-len(cloud) // MOST_POINTS)
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
