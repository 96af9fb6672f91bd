"""Pictures of an evaluation on real objects: confusions and reliability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from circumspect.evaluation.crop_report import percent, shortened
from circumspect.evaluation.figure_canvas import new_figure
from circumspect.evaluation.figures import ACCENT, WRONG

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CELL = 0.45
"""Side of a cell of the confusion matrix [inch]."""


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
