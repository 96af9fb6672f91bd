"""Pictures of an evaluation on real objects: confusions, reliability, wrong answers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.labelled_crops import LabelledCrops
from circumspect.evaluation.crop_answers import CropAnswer
from circumspect.evaluation.crop_report import percent, shortened
from circumspect.evaluation.figures import WRONG
from circumspect.figure_canvas import ACCENT, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CELL = 0.45
"""Side of a cell of the confusion matrix [inch]."""
COLUMNS, ROWS = 6, 4
"""Objects on a page."""
MAX_POINTS = 4000
"""Drawn points of an object."""
GAP = 0.08
"""Gap between side view and top view, in units of the larger of the two."""
PICTURE_SIZE = (2.7, 3.1)
"""Width and height of an object [inch]."""


def draw_crop_confusion(metrics: Mapping[str, Any]) -> Figure:
    """Counts of answers by label; the darker a cell, the larger its share of the row.

    Correct answers are blue, wrong ones red, and answers to other kinds grey.

    Args:
        metrics: From `crop_metrics`.
    """
    classes = metrics["classes"]
    known = [
        (name, counts)
        for name, counts in zip(classes, metrics["confusion"], strict=True)
        if any(counts)
    ]
    others = [
        (label, [counts.get(name, 0) for name in classes])
        for label, counts in metrics["other_kind_answers"].items()
    ]
    rows = [*known, *others]
    counts = np.array([row for _, row in rows]).reshape(len(rows), len(classes))
    size = (3.0 + CELL * len(classes), 2.4 + CELL * max(len(rows), 2))
    figure = new_figure((max(size[0], 5.0), size[1]))
    axes = figure.add_subplot()
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axes.imshow(_colours(shares, [name for name, _ in known], classes), aspect="equal")
    names = [shortened(name).replace("_", " ") for name in classes]
    axes.set_xticks(range(len(classes)), names, rotation=40, ha="right")
    labels = [shortened(label).replace("_", " ") for label, _ in rows]
    totals = counts.sum(axis=1)
    axes.set_yticks(
        range(len(rows)), [f"{name} ({n})" for name, n in zip(labels, totals, strict=True)]
    )
    for (row, column), value in np.ndenumerate(counts):
        if value:
            colour = "white" if shares[row, column] > 0.6 else "black"
            axes.text(column, row, str(value), ha="center", va="center", fontsize=10, color=colour)
    if known and others:
        axes.axhline(len(known) - 0.5, color="black", linewidth=1.5)
    axes.set_xlabel("answer")
    axes.set_ylabel("label (objects)")
    below = "; below the line: other kinds" if known and others else ""
    axes.set_title(f"Answers to real objects{below}", fontsize=11)
    return figure


def _colours(
    shares: NDArray[np.float64], known: Sequence[str], classes: Sequence[str]
) -> NDArray[np.float64]:
    """(r, c, 4) colours of the cells; rows are the known classes, then other kinds."""
    from matplotlib import colormaps

    correct = np.array([[name == column for column in classes] for name in known])
    others = np.zeros((len(shares) - len(known), len(classes)), bool)
    correct = np.concatenate([correct.reshape(len(known), len(classes)), others])
    colours = np.where(
        correct[..., None], colormaps["Blues"](0.8 * shares), colormaps["Reds"](0.8 * shares)
    )
    colours[len(known) :] = colormaps["Greys"](0.6 * shares[len(known) :])
    colours[shares == 0] = 1.0
    return colours


def draw_crop_reliability(metrics: Mapping[str, Any]) -> Figure:
    """Accuracy by probability with 95 % intervals, and how many answers each bin has.

    Args:
        metrics: From `crop_metrics`.
    """
    bins = metrics["probability_bins"]
    figure = new_figure((6.4, 6.4))
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    upper.plot([0, 100], [0, 100], color="black", linewidth=1, linestyle="--")
    for row in bins:
        left, width = 100 * row["above"], 100 * (row["up_to"] - row["above"])
        lower.bar(left, row["objects"], width, align="edge", color=ACCENT, alpha=0.7)
        lower.text(
            left + width / 2, row["objects"], str(row["objects"]), ha="center", va="bottom",
            fontsize=9,
        )  # fmt: skip
        if not row["objects"]:
            continue
        accuracy, (low, high) = 100 * row["share"], row["interval"]
        upper.bar(left, accuracy, width, align="edge", color=ACCENT, alpha=0.25)
        upper.errorbar(
            [100 * row["mean_probability"]], [accuracy],
            yerr=[[max(0.0, accuracy - 100 * low)], [max(0.0, 100 * high - accuracy)]],
            fmt="o", color=WRONG, markersize=5, capsize=3, linewidth=1.2,
        )  # fmt: skip
    count = sum(row["objects"] for row in bins)
    error = percent(metrics["expected_calibration_error"])
    upper.set_title(
        f"Expected calibration error {error}: {count} real objects of known classes\n"
        "points with 95 % intervals (Wilson); dashed: perfectly calibrated",
        fontsize=11,
    )
    upper.set_ylabel("accuracy [%]")
    upper.set_ylim(-3, 105)
    lower.set_ylabel("answers")
    lower.set_ylim(0, 1.25 * max(1, *(row["objects"] for row in bins)))
    lower.set_xlabel("probability of the answer [%]")
    lower.set_xlim(0, 100)
    return figure


def draw_errors(
    answers: Sequence[CropAnswer], sources: Mapping[str, LabelledCrops]
) -> list[Figure]:
    """Pages of the wrongly classified objects, the most probable answers first.

    Of other kinds, objects with a confident answer are included.

    Args:
        answers: From `answer_crops`, all of them and in its order.
        sources: The classified objects.

    Returns:
        A figure per 24 objects; none without errors.
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
    figure = new_figure((max(PICTURE_SIZE[0] * columns, 6.0), PICTURE_SIZE[1] * rows + 0.6))
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
    chosen = np.linspace(0, len(up) - 1, min(len(up), MAX_POINTS)).astype(int)
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
    # A rotation, not a reflection.
    along, across = plane @ (x, y), plane @ (-y, x)
    return along, across, points_xyz[:, 2] - points_xyz[:, 2].min()
