"""The picture of a room with ceiling cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.evaluation.figures import save_figure
from circumspect.figure_canvas import new_figure
from circumspect.geometry import Trajectory
from circumspect.localization import FixedCamera, SpaceTrack

if TYPE_CHECKING:
    from matplotlib.axes import Axes

VIEW_COLOURS = ("#0e7490", "#a16207", "#7c3aed", "#15803d", "#be185d", "#475569")
SPACE_COLOUR, INK = "#1d4ed8", "0.25"
PATH_LOOKS = (("0.15", "--", 1.4), ("#c2410c", "-", 1.6), ("#15803d", "-.", 1.4))
ELLIPSE_SHARE = 0.06
"""Half size of the median ellipse, as a fraction of the picture's half width."""


def draw_space(
    path: Path,
    cameras: Sequence[FixedCamera],
    plane: float,
    track: SpaceTrack,
    paths: Mapping[str, Trajectory],
    truth: Trajectory | None = None,
    walls_xy: Sequence[NDArray[np.float64]] = (),
    object_xy: NDArray[np.float64] | None = None,
    title: str = "Intelligent space",
) -> None:
    """Draw cameras, their views, and the paths from all sources.

    Args:
        path: The PNG to write.
        cameras: Of the room.
        plane: Height of the tag [m], at which the views are cut.
        track: Fixes of the intelligent space.
        paths: Other paths in map by name: odometry, the pipeline's.
        truth: The true path of the base; None where unknown.
        walls_xy: Outlines of walls and furniture [m].
        object_xy: (n, 2) or (n, 3) points of the object [m]; their outline is drawn.
        title: Of the picture.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OutputError: The file cannot be written.
    """
    figure = new_figure((11.5, 7.6))
    plan, side = figure.subplots(1, 2, width_ratios=(2.4, 1))
    for line in walls_xy:
        plan.fill(*np.asarray(line).T, facecolor="0.90", edgecolor="0.65", lw=0.8, zorder=0)
    if object_xy is not None:
        plan.fill(*_outline(object_xy).T, facecolor="#e7c9a9", edgecolor="#8a5a2b", zorder=1)
    _draw_views(plan, cameras, plane)
    if truth is not None:
        plan.plot(
            *truth.positions_xyz[:, :2].T, color="0.1", lw=4.5, alpha=0.22, zorder=3,
            label="true path",
        )  # fmt: skip
    for (name, trajectory), (colour, style, width) in zip(paths.items(), PATH_LOOKS, strict=False):
        plan.plot(
            *trajectory.positions_xyz[:, :2].T, style, color=colour, lw=width, zorder=4, label=name
        )
    _draw_track(plan, track)
    plan.set(aspect="equal", xlabel="x [m], map", ylabel="y [m], map")
    plan.set_title(title, loc="left", color=INK)
    if plan.get_legend_handles_labels()[0]:
        plan.legend(loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=2, frameon=False)
    _draw_share(side, cameras, track)
    save_figure(figure, path)


def _outline(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 2) convex, seen from above."""
    from scipy.spatial import ConvexHull

    flat = points[:, :2]
    return flat[ConvexHull(flat).vertices]


def _draw_views(axes: Axes, cameras: Sequence[FixedCamera], plane: float) -> None:
    for number, camera in enumerate(cameras):
        colour = VIEW_COLOURS[number % len(VIEW_COLOURS)]
        edge = camera.outline_xy(plane)
        edge = edge[np.isfinite(edge).all(axis=1)]
        axes.fill(*edge.T, facecolor=colour, alpha=0.06, zorder=1)
        axes.plot(*edge.T, color=colour, lw=1, alpha=0.7, zorder=2)
        x, y = camera.position_xyz[:2]
        axes.plot(x, y, "s", color=colour, ms=8, mec="white", zorder=6)
        axes.annotate(
            f"{camera.name}, {camera.position_xyz[2]:.1f} m", (x, y), xytext=(7, 6),
            textcoords="offset points", color=colour, fontsize=9, zorder=6,
        )  # fmt: skip


def _draw_track(axes: Axes, track: SpaceTrack) -> None:
    tracked, known = track.known(bridged=False), track.known()
    label = "path by the intelligent space"
    if (error := track.stated_error_m) is not None:
        label += f" (± {1e3 * error:.1f} mm)"
    places = np.array([f.T_map_base.xy for f in tracked if f.T_map_base is not None])
    if len(places):
        axes.plot(*places.T, ".", color=SPACE_COLOUR, ms=6, alpha=0.35, zorder=3.5, label=label)
    bridged = [f.T_map_base.xy for f in known if f.state != "tracked" and f.T_map_base is not None]
    if bridged:
        axes.plot(
            *np.array(bridged).T, "x", color="#b91c1c", ms=5, zorder=5, label="bridged drop-outs"
        )


def _draw_share(axes: Axes, cameras: Sequence[FixedCamera], track: SpaceTrack) -> None:
    """Camera in use over time, with hand-overs."""
    if not track.fixes:
        axes.set_axis_off()
        return
    start = track.fixes[0].stamp
    for number, camera in enumerate(cameras):
        used = [f.stamp - start for f in track.fixes if camera.name in f.cameras]
        doubted = [
            f.stamp - start
            for f in track.fixes
            if any(
                s.camera == camera.name and s.pose is not None and not s.used for s in f.sightings
            )
        ]
        colour = VIEW_COLOURS[number % len(VIEW_COLOURS)]
        axes.plot(np.full(len(used), number), used, "_", color=colour, ms=14)
        axes.plot(np.full(len(doubted), number) + 0.3, doubted, "_", color="#b91c1c", ms=5)
    rest = len(cameras)
    for state, colour in (("bridged", "#f59e0b"), ("lost", "#b91c1c")):
        when = [f.stamp - start for f in track.fixes if f.state == state]
        axes.plot(np.full(len(when), rest), when, "_", color=colour, ms=14, label=state)
    names = [camera.name for camera in cameras] + ["bridged\nor lost"]
    axes.set_xticks(range(len(names)), names, rotation=55, ha="right", fontsize=9)
    axes.set(ylabel="time [s]", xlim=(-0.7, rest + 0.7))
    axes.invert_yaxis()
    axes.set_title("Camera in use", loc="left", color=INK)
    axes.spines[["top", "right"]].set_visible(False)
