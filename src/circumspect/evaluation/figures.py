"""Pictures of an evaluation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets import ObjectSet
from circumspect.errors import printable
from circumspect.evaluation.calibration import Reliability, reliability
from circumspect.evaluation.yaw_sweep import YawSweep
from circumspect.figure_canvas import ACCENT, new_figure
from circumspect.storage import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WRONG = "#b8402a"


def draw_all(sweep: YawSweep, objects: ObjectSet, folder: Path) -> list[Path]:
    """Draw accuracy over yaw, the confusion matrix, reliability and the most probable errors.

    Returns:
        The files written.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OutputError: A file cannot be written.
    """
    figures = {
        "accuracy_over_yaw.png": draw_accuracy_over_yaw(sweep),
        "confusion.png": draw_confusion(sweep.confusion, sweep.classes, yaws_of(sweep)),
        "reliability.png": draw_reliability(
            reliability(*sweep.flat), f"{len(sweep.labels)} objects, {yaws_of(sweep)}"
        ),
        "probable_errors.png": draw_probable_errors(sweep, objects),
    }
    for name, figure in figures.items():
        save_figure(figure, folder / name)
    return [folder / name for name in figures]


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as PNG.

    Raises:
        OutputError: It cannot be written.
    """
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=130, facecolor="white")


def draw_accuracy_over_yaw(sweep: YawSweep) -> Figure:
    """Accuracy over yaw, with its extremes in the title."""
    figure = new_figure((9.0, 5.0))
    axes = sweep.plot(figure.add_subplot())
    percent = 100.0 * sweep.accuracy
    axes.set_title(
        f"Accuracy over yaw: {percent.min():.1f} to {percent.max():.1f} %\n"
        f"{len(sweep.labels)} objects, {yaws_of(sweep)}, "
        f"{100 * sweep.flip_rate:.1f} % change their label",
        fontsize=11,
    )
    return figure


def draw_confusion(counts: NDArray[np.int64], classes: Sequence[str], over: str) -> Figure:
    """Confusion matrix, in percent of each true class.

    Args:
        counts: (c, c) answers; row is the true class.
        classes: Their names.
        over: Description of the answers, such as "64 yaws".
    """
    figure = new_figure((7.2, 6.4))
    axes = figure.add_subplot()
    percent = 100.0 * counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axes.imshow(percent, cmap="Blues", vmin=0, vmax=100)
    names = [name.replace("_", " ") for name in classes]
    axes.set_xticks(range(len(names)), names, rotation=40, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.set_xlabel("answer")
    axes.set_ylabel("true class")
    for (row, column), value in np.ndenumerate(percent):
        if value >= 0.05:
            text = f"{value:.1f}" if value < 99.95 else "100"
            colour = "white" if value > 55 else "black"
            axes.text(column, row, text, ha="center", va="center", fontsize=8, color=colour)
    axes.set_title(f"Share of each class [%], over {over}", fontsize=11)
    return figure


def yaws_of(sweep: YawSweep) -> str:
    """Number of yaws of a sweep, in words."""
    count = len(sweep.yaw_deg)
    return "1 yaw" if count == 1 else f"{count} yaws"


def draw_reliability(found: Reliability, of: str) -> Figure:
    """Accuracy and frequency of answers by probability.

    Args:
        found: The reliability.
        of: Description of the answers, such as "100 objects".
    """
    figure = new_figure((6.4, 6.4))
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    width = np.diff(found.edges)
    upper.bar(found.edges[:-1], 100 * found.accuracy, width, align="edge", color=ACCENT, alpha=0.7)
    upper.plot([0, 1], [0, 100], color="black", linewidth=1, linestyle="--")
    upper.plot(found.confidence, 100 * found.accuracy, "o", color=WRONG, markersize=4)
    upper.set_ylabel("accuracy [%]")
    upper.set_ylim(0, 100)
    upper.set_title(
        f"Expected calibration error {found.expected_error:.3f}: {of}",
        fontsize=11,
    )
    share = 100 * found.counts / found.counts.sum()
    lower.bar(found.edges[:-1], share, width, align="edge", color=ACCENT, alpha=0.7)
    lower.set_ylabel("answers [%]")
    lower.set_xlabel("probability of the answer")
    lower.set_xlim(0, 1)
    return figure


def draw_probable_errors(sweep: YawSweep, objects: ObjectSet, count: int = 15) -> Figure:
    """The wrongly classified objects with the highest mean probability."""
    figure = new_figure((11, 7))
    mean = sweep.probabilities.mean(axis=0)
    answers = mean.argmax(axis=1)
    wrong = np.nonzero(answers != sweep.labels)[0]
    chosen = wrong[np.argsort(-mean[wrong, answers[wrong]])][:count]
    figure.suptitle(
        f"Most probable of {len(wrong)} errors among {len(sweep.labels)} objects", fontsize=12
    )
    for cell, index in enumerate(chosen):
        axes = figure.add_subplot(3, 5, cell + 1)
        _draw_object(axes, objects.points_xyz[index])
        truth, answer = sweep.classes[sweep.labels[index]], sweep.classes[answers[index]]
        name = printable(str(objects.names[index]))
        axes.set_title(
            f"{name}\ncalled {answer}, {100 * mean[index, answers[index]]:.0f} %"
            if truth in name
            else f"{name} ({truth})\ncalled {answer}",
            fontsize=8,
            color=WRONG,
        )
    return figure


def _draw_object(axes: Axes, points_xyz: np.ndarray) -> None:
    """Points from the front, right and above; near ones are dark."""
    yaw, pitch = np.deg2rad(35.0), np.deg2rad(25.0)
    x, y, z = points_xyz.T
    right, away = np.cos(yaw) * x + np.sin(yaw) * y, -np.sin(yaw) * x + np.cos(yaw) * y
    up, depth = np.cos(pitch) * z + np.sin(pitch) * away, np.cos(pitch) * away - np.sin(pitch) * z
    order = np.argsort(-depth)
    axes.scatter(right[order], up[order], c=-depth[order], s=5, cmap="bone_r", linewidths=0)
    axes.set_aspect("equal")
    axes.margins(0.08)
    axes.axis("off")
