"""Pictures of real objects that were named wrongly: each from the side and from above."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.labelled_crops import LabelledCrops
from circumspect.evaluation.crop_answers import CropAnswer
from circumspect.evaluation.crop_report import percent, shortened
from circumspect.evaluation.figure_canvas import new_figure
from circumspect.evaluation.figures import WRONG

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS, ROWS = 6, 4
"""Objects on a page."""
MOST_POINTS = 4000
"""Drawn of an object."""
GAP = 0.08
"""Between side view and top view, in units of the larger of the two."""
CELL = (2.7, 3.1)
"""Width and height of an object [inch]."""


def draw_errors(
    answers: Sequence[CropAnswer], sources: Mapping[str, LabelledCrops]
) -> list[Figure]:
    """Pages of the objects that were named wrongly, the most probable answers first.

    Of other kinds those are shown whose answer was confident.

    Args:
        answers: From `answer_crops`, all of them and in its order.
        sources: What they are answers to.

    Returns:
        A figure for every 24 objects; none where there are no errors.
    """
    objects = [(crops, index) for crops in sources.values() for index in range(len(crops))]
    wrong = [
        (answer, *place) for answer, place in zip(answers, objects, strict=True) if answer.is_error
    ]
    wrong.sort(key=lambda row: -row[0].probability)
    per_page = COLUMNS * ROWS
    pages = math.ceil(len(wrong) / per_page)
    return [
        _page(wrong[number * per_page : (number + 1) * per_page], len(wrong), number + 1, pages)
        for number in range(pages)
    ]


def _page(
    shown: Sequence[tuple[CropAnswer, LabelledCrops, int]], count: int, number: int, pages: int
) -> Figure:
    columns = min(COLUMNS, len(shown))
    rows = math.ceil(len(shown) / columns)
    figure = new_figure((max(CELL[0] * columns, 6.0), CELL[1] * rows + 0.6))
    page = f", page {number} of {pages}" if pages > 1 else ""
    noun = "object" if count == 1 else "objects"
    figure.suptitle(
        f"{count} wrongly named real {noun}{page}:{' ' if columns > 3 else chr(10)}"
        "above from the side, below from above; colour is height",
        fontsize=12 if columns > 3 else 10,
    )
    for cell, (answer, crops, index) in enumerate(shown, start=1):
        axes = figure.add_subplot(rows, columns, cell)
        size = _draw_views(axes, crops.cloud(index).points_xyz)
        axes.set_title(
            f"{_name(answer.label)} → {_name(answer.answer)} {percent(answer.probability)}",
            fontsize=10,
            color=WRONG,
            fontweight="bold",
            pad=16,
        )
        sides = " × ".join(f"{side:.1f}" for side in size)
        axes.text(
            0.5, 1.01, f"{shortened(answer.scene, 20)}, {sides} m",
            transform=axes.transAxes, ha="center", va="bottom", fontsize=8,
        )  # fmt: skip
    return figure


def _name(label: str) -> str:
    return shortened(label, 15).replace("_", " ")


def _draw_views(axes: Axes, points_xyz: NDArray[np.float64]) -> tuple[float, float, float]:
    """Side view above top view, to one scale.

    Returns:
        Length, depth and height [m] of the box along the principal axes.
    """
    along, across, up = _principal(points_xyz)
    size = float(np.ptp(along)), float(np.ptp(across)), float(np.ptp(up))
    chosen = np.linspace(0, len(up) - 1, min(len(up), MOST_POINTS)).astype(int)
    along, across, up = along[chosen], across[chosen], up[chosen]
    gap = GAP * max(size)
    # Near points are drawn last: those of small `across` from the side, high ones from above.
    side, top = np.argsort(-across), np.argsort(up)
    x = np.concatenate([along[side], along[top]])
    y = np.concatenate([up[side] - up.min() + gap / 2, across[top] - across.max() - gap / 2])
    colours = np.concatenate([up[side], up[top]])
    axes.scatter(x, y, c=colours, s=np.clip(4000 / len(up), 1.6, 6.0), cmap="viridis", linewidths=0)
    axes.axhline(0.0, color="#999999", linewidth=0.6)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_color("#cccccc")
    return size


def _principal(points_xyz: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """(n,) coordinates along the longer and the shorter horizontal axis, and the height."""
    plane = points_xyz[:, :2] - points_xyz[:, :2].mean(axis=0)
    x, y = np.linalg.eigh(plane.T @ plane)[1][:, 1]
    # A turn, not a mirror image.
    along, across = plane @ (x, y), plane @ (-y, x)
    return along, across, points_xyz[:, 2] - points_xyz[:, 2].min()
