"""A picture of evidence: an object coloured by its evidence, and its grid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import CellEvidence, NearExample
from circumspect.classification.answer_text import percent
from circumspect.classification.evidence_plot import (
    draw_cells,
    draw_evidence_grid,
    evidence_colours,
    evidence_span,
    strongest,
)
from circumspect.errors import printable
from circumspect.figure_canvas import new_figure
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

SIDES_DEG = (-60.0, 30.0, 120.0, 210.0)
ELEVATION_DEG = 22.0
MAX_POINTS = 24_000
MAX_NAMES = 12
"""Named training objects."""


def draw_evidence(
    explained: CellEvidence,
    cloud: PointCloud,
    near: Sequence[NearExample] = (),
    unit: str = "m",
) -> Figure:
    """The object from four sides, its grid, the probabilities and the nearest training objects.

    Args:
        explained: The evidence.
        cloud: The object's surface, in the frame of the grid.
        near: Training objects, the nearest first; `MAX_NAMES` of them are named.
        unit: Of the coordinates, as the axes name it.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    figure = new_figure((13.0, 7.2))
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.15, 1.0))
    above, below = parts
    span = evidence_span(explained.cells)
    step = -(-len(cloud) // MAX_POINTS)
    points = cloud.points_xyz[::step]
    colours = evidence_colours(explained.at(points), span) / 255.0
    for axes, azimuth in zip(above.subplots(1, len(SIDES_DEG)), SIDES_DEG, strict=True):
        _draw_side(axes, points, colours, azimuth)
    unrolled, plan, words = below.subplots(1, 3, width_ratios=(1.9, 1.1, 1.1))
    _draw_grid(unrolled, plan, explained, span, unit)
    _draw_bar(above, explained.label, span)
    _draw_words(words, explained, near)
    figure.suptitle(
        f"{explained.label}: what speaks for it and what against it "
        f"(log-odds {explained.log_odds:+.1f})",
        fontsize=12,
    )
    return figure


def _draw_side(
    axes: Axes, points: NDArray[np.float64], colours: NDArray[np.float64], azimuth_deg: float
) -> None:
    """Orthographic view; distant points are paler, and near ones cover them."""
    azimuth, elevation = np.radians([azimuth_deg, ELEVATION_DEG])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    towards = level * np.cos(elevation) + np.array([0.0, 0.0, np.sin(elevation)])
    up = np.cross(towards, right)
    centred = points - (points.min(axis=0) + points.max(axis=0)) / 2
    nearness = centred @ towards
    order = np.argsort(nearness)
    far = (nearness.max() - nearness) / max(float(np.ptp(nearness)), 1e-12)
    shown = colours + (1.0 - colours) * (0.55 * far**1.5)[:, None]
    reach = float(np.linalg.norm(centred, axis=1).max()) or 1.0
    size = 2.0 if len(points) > 6000 else 7.0
    axes.scatter(
        (centred @ right)[order], (centred @ up)[order], c=shown[order], s=size, linewidths=0
    )
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    axes.set_title(f"from {azimuth_deg % 360:.0f}°", fontsize=9)


def _draw_grid(unrolled: Axes, plan: Axes, explained: CellEvidence, span: float, unit: str) -> None:
    """Of the cells along each line of sight the strongest; of a box front and plan."""
    cells = explained.cells
    draw_evidence_grid(unrolled, cells, explained.grid, unit)
    bounds = explained.grid.grid
    if isinstance(bounds, CylindricalGrid):
        draw_cells(
            plan, strongest(cells, explained.grid, 2), span, (0, bounds.radius, 0, 360), "auto"
        )
        plan.set(xlabel=f"radius [{unit}]", ylabel="azimuth [°]", title="grid, from above")
        plan.set_yticks(range(0, 361, 90))
        return
    half = bounds.half_width  # pyright: ignore[reportAttributeAccessIssue]
    draw_cells(plan, strongest(cells, explained.grid, 2), span, (-half, half, -half, half), "equal")
    plan.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]", title="grid, from above")


def _draw_bar(figure: SubFigure, label: str, span: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    steps = np.linspace(-span, span, 256)
    colours = ListedColormap(evidence_colours(steps, span) / 255.0)
    figure.colorbar(
        ScalarMappable(Normalize(-span, span), colours),
        ax=figure.axes,
        label=f"evidence for {label}\n(fall of log-odds)",
        shrink=0.85,
    )


def _draw_words(axes: Axes, explained: CellEvidence, near: Sequence[NearExample]) -> None:
    axes.set_axis_off()
    ranked = sorted(explained.prediction.probabilities.items(), key=lambda item: -item[1])[:4]
    lines = [f"{name.replace('_', ' '):<14}{percent(share):>6}" for name, share in ranked]
    if near:
        lines += ["", "nearest training objects"]
        named = near[:MAX_NAMES]
        lines += [f"{printable(example.name):<18}{example.distance:6.3f}" for example in named]
    if len(near) > MAX_NAMES:
        lines.append(f"… and {len(near) - MAX_NAMES} more")
    axes.text(0.0, 0.98, "\n".join(lines), va="top", family="monospace", fontsize=9)
