"""The plan view of a run: room, object, paths and chosen views."""

from __future__ import annotations

import re
from collections.abc import Sequence
from textwrap import fill, shorten
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PointCloud, Trajectory
from circumspect.recognition import RecognitionResult
from circumspect.runs.run_path import PlannedView, RunPath, camera_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PATH_COLOUR, START_COLOUR, VIEW_COLOUR, INK = "#c2410c", "#15803d", "#1d4ed8", "0.25"
ODOMETRY_COLOUR, TRUTH_COLOUR, MISSED_COLOUR = "#7c3aed", "0.1", "0.5"
NORMAL_LENGTH = 0.06
"""Length of the arrows of surface normals, as a fraction of the view's width."""
SPACING = 0.015
"""Side of a point as drawn [m]."""
LABEL_OFFSET, LABEL_ROOM = 15, 22
"""Distance from a position to the centre of its label, and from there to a number [pt]."""
LEGEND_WIDTH, LEGEND_LINES = 46, 5
"""Characters in a line of the legend, and maximum number of lines of an entry."""
MARGIN = 0.25
"""Margin around the shown region [m]."""


def draw_plan(
    axes: Axes,
    cloud: PointCloud,
    result: RecognitionResult,
    run_path: RunPath,
    why_missed: Sequence[str] = (),
) -> None:
    """Draw the plan view; unknown parts of the path are left out.

    Args:
        axes: Axes to draw into.
        cloud: The model.
        result: The run.
        run_path: The path of the robot.
        why_missed: The reason of each missed view; empty if unknown.
    """
    path = camera_path(result)
    for number, line in enumerate(run_path.walls_xy):
        label = "wall or clutter" if number == 0 else None
        axes.fill(*line.T, facecolor="0.88", edgecolor="0.6", lw=0.8, zorder=0, label=label)
    drawn = [np.empty((0, 2)), *_draw_paths(axes, path, run_path)]
    half = _frame(axes, np.concatenate([*drawn, cloud.points_xyz[:, :2]]))
    _draw_object(axes, cloud, half)
    for number, view in enumerate(run_path.views, start=1):
        _draw_view(axes, view, number, NORMAL_LENGTH * 2 * half)
    _draw_missed(axes, run_path.missed, why_missed)
    if path is not None:
        if not run_path.views:
            _draw_directions(axes, path, half)
        middle = cloud.points_xyz[:, :2].mean(axis=0)
        _draw_start(axes, path.positions_xyz[0, :2], middle, run_path, half)
    axes.set_title("Plan view (colour: height z [m])", loc="left", color=INK)
    # A run may have ended before its first pose.
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            loc="upper center", bbox_to_anchor=(0.48, -0.1), ncols=2, frameon=False, fontsize=10.5,
            handlelength=1.8, columnspacing=1.6,
        )  # fmt: skip


def _draw_object(axes: Axes, cloud: PointCloud, half: float) -> None:
    points = cloud.points_xyz
    # Markers as large as the points' spacing make a surface look closed.
    side = SPACING / _metres_a_point(axes, half)
    shades = axes.scatter(
        points[:, 0], points[:, 1], c=points[:, 2], s=max(1.0, side**2), cmap="viridis",
        linewidths=0, zorder=2,
    )  # fmt: skip
    axes.figure.colorbar(shades, cax=axes.inset_axes((1.02, 0.0, 0.02, 0.35)))


def _draw_paths(
    axes: Axes, path: Trajectory | None, run_path: RunPath
) -> list[NDArray[np.float64]]:
    """Draw the paths; returns the positions on them."""
    looks = (
        (run_path.truth, TRUTH_COLOUR, "-", 3.0, 0.28, "true path"),
        (run_path.odometry, ODOMETRY_COLOUR, "--", 1.3, 1.0, "path by odometry alone"),
        (path, PATH_COLOUR, "-", 1.6, 1.0, "path of the camera, estimated"),
    )
    drawn = []
    for trajectory, colour, style, width, alpha, label in looks:
        if trajectory is not None:
            drawn.append(trajectory.positions_xyz[:, :2])
            axes.plot(
                *drawn[-1].T, style, color=colour, lw=width, alpha=alpha, label=label, zorder=3
            )
    return drawn


def _draw_view(axes: Axes, view: PlannedView, number: int, length: float) -> None:
    """Draw a numbered base pose, the point that the camera faces, and the surface normal there."""
    stand, target = view.T_map_base.xy, np.asarray(view.looks_at_xy)
    label = "base pose (camera beside it), point that it faces" if number == 1 else None
    axes.plot(*np.stack([stand, target]).T, ":", color=VIEW_COLOUR, lw=0.9, zorder=3, label=label)
    if view.normal_xy is not None:
        axes.annotate(
            "", _pair(target + length * np.asarray(view.normal_xy)), _pair(target), zorder=4,
            arrowprops={"arrowstyle": "-|>", "color": VIEW_COLOUR, "lw": 1.4, "shrinkA": 0},
        )  # fmt: skip
        if number == 1:
            axes.plot([], [], ">-", color=VIEW_COLOUR, lw=1.4, ms=5, label="surface normal")
    axes.plot(*stand, "o", color="white", mec=VIEW_COLOUR, mew=1.1, ms=12, zorder=5)
    axes.annotate(
        str(number), _pair(stand), ha="center", va="center_baseline", fontsize=7.5,
        color=VIEW_COLOUR, zorder=6,
    )  # fmt: skip


def _draw_missed(axes: Axes, views: tuple[PlannedView, ...], why: Sequence[str]) -> None:
    """Draw numbered crosses; the legend lists the reasons by number."""
    if not views:
        return
    places = np.array([view.T_map_base.xy for view in views])
    reasons = shorten(f"not reached{_reasons(why)}", LEGEND_WIDTH * LEGEND_LINES, placeholder=" …")
    reasons = fill(reasons, LEGEND_WIDTH)
    axes.plot(*places.T, "x", color=MISSED_COLOUR, ms=7, mew=1.6, zorder=4, label=reasons)
    for number, place in enumerate(places, start=1):
        axes.annotate(
            str(number), _pair(place), xytext=(6, 5), textcoords="offset points", fontsize=7.5,
            color=MISSED_COLOUR, va="center_baseline", annotation_clip=True, zorder=6,
            bbox={"boxstyle": "circle,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.8},
        )  # fmt: skip


def _reasons(why: Sequence[str]) -> str:
    """The distinct reasons, without distances, with the numbers of their views."""
    numbers: dict[str, list[str]] = {}
    for number, reason in enumerate(why, start=1):
        numbers.setdefault(re.sub(r"[\d.]+ m\b", "… m", reason), []).append(str(number))
    reasons = "; ".join(f"{', '.join(of)} {reason}" for reason, of in numbers.items())
    return f": {reasons}" if reasons else ""


def _draw_directions(axes: Axes, path: Trajectory, half: float) -> None:
    """Draw viewing directions of the camera at some points of its path."""
    places = path.positions_xyz[:, :2]
    far = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    some = np.unique(np.searchsorted(far, np.arange(0, far[-1] + 1e-9, half / 7)))
    looks = path.T_map_camera.rotation.as_matrix()[some, :2, 2]
    looks = looks / np.maximum(np.linalg.norm(looks, axis=1, keepdims=True), 1e-9)
    axes.quiver(
        *places[some].T, *looks.T, color=PATH_COLOUR, width=0.006, scale=4.5,
        scale_units="inches", units="width", headwidth=4.5, zorder=3,
    )  # fmt: skip


def _draw_start(
    axes: Axes,
    place: NDArray[np.float64],
    middle: NDArray[np.float64],
    run_path: RunPath,
    half: float,
) -> None:
    axes.plot(*place, "o", color=START_COLOUR, ms=10, mec="white", mew=1.5, zorder=7)
    stands = [view.T_map_base.xy for view in run_path.views]
    away = _free_side(place, middle, stands, _metres_a_point(axes, half))
    axes.annotate(
        "start", _pair(place), xytext=_pair(LABEL_OFFSET * away),
        textcoords="offset points", color=START_COLOUR, fontweight="bold", ha="center",
        va="center", zorder=7,
    )  # fmt: skip


def _free_side(
    place: NDArray[np.float64],
    middle: NDArray[np.float64],
    stands: list[NDArray[np.float64]],
    metres_a_point: float,
) -> NDArray[np.float64]:
    """Unit vector towards free space for the label; outward if there is a choice."""
    outward = np.arctan2(*(place - middle)[::-1])
    turns = outward + np.radians([0.0, 50.0, -50.0, 100.0, -100.0, 180.0])
    sides = np.column_stack([np.cos(turns), np.sin(turns)])
    if not stands:
        return sides[0]
    spots = place + LABEL_OFFSET * metres_a_point * sides
    gaps = np.linalg.norm(spots[:, None] - np.array(stands), axis=2).min(axis=1)
    return sides[int(np.argmax(gaps >= min(gaps.max(), LABEL_ROOM * metres_a_point)))]


def _metres_a_point(axes: Axes, half: float) -> float:
    """Size [m] of a typographic point in a view of width 2 `half` [m]."""
    return 2 * half * axes.figure.dpi / (72 * axes.bbox.width)


def _pair(xy: NDArray[np.floating]) -> tuple[float, float]:
    return float(xy[0]), float(xy[1])


def _frame(axes: Axes, points_xy: NDArray[np.float64]) -> float:
    """Set square limits around the relevant parts; return half their width [m]."""
    low, high = points_xy.min(axis=0), points_xy.max(axis=0)
    x, y = (low + high) / 2
    half = float((high - low).max()) / 2 + MARGIN + 0.1 * float((high - low).max())
    axes.set(
        xlim=(x - half, x + half), ylim=(y - half, y + half), aspect="equal",
        xlabel="x [m], map", ylabel="y [m], map",
    )  # fmt: skip
    return half
