"""Plot of the answers of a run."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import Prediction
from circumspect.classification.answer_text import percent
from circumspect.figure_canvas import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CLASS_COLOURS = ("#1d4ed8", "#c2410c", "#15803d", "#7c3aed", "#0e7490")
MOST_CURVES = 4


def draw_answers(
    axes: Axes,
    answers: Sequence[Prediction | None],
    used: Sequence[bool],
    along: NDArray[np.float64],
    what: str,
) -> None:
    """Draw the probabilities of the leading classes over frames or distance.

    Unused frames are marked at the bottom. Without an answer no curve is drawn.

    Args:
        axes: Axes to draw into.
        answers: Answers of n ≥ 1 frames; None before the first answer.
        used: Whether each frame was used.
        along: (n,) horizontal position of each frame.
        what: Label of the horizontal axis.
    """
    _draw_curves(axes, answers, along, MOST_CURVES)
    unused = [number for number, was_used in enumerate(used) if not was_used]
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
    # The title leaves room for the note, which would hide curves within the axes.
    axes.set_title("Answer on the way", loc="left", color=INK, pad=20 if unused else None)


def _draw_curves(
    axes: Axes, answers: Sequence[Prediction | None], along: NDArray[np.float64], most: int
) -> None:
    """Draw a curve per class, that of the final answer first."""
    given = [(number, answer) for number, answer in enumerate(answers) if answer is not None]
    if not given:
        axes.text(0.5, 0.5, "no answer", ha="center", transform=axes.transAxes, color=INK)
        return
    final = given[-1][1]
    names = list(final.probabilities)
    table = np.array([[answer.probabilities[name] for name in names] for _, answer in given])
    places = along[[index for index, _ in given]]
    # The final answer first, then by the final probability and the mean over the run.
    weights = table[-1] + 0.25 * table.mean(axis=0)
    weights[names.index(final.label)] = np.inf
    rank = np.argsort(-weights)[:most]
    ends = _spread_labels(table[-1, rank], 0.075)
    style = "-o" if len(given) <= 60 else "-"
    for place, (index, colour) in enumerate(zip(rank, CLASS_COLOURS, strict=False)):
        axes.plot(
            places, table[:, index], style, color=colour, lw=2.4 if place == 0 else 1.5, ms=2.5
        )
        axes.annotate(
            f"{names[index].replace('_', ' ')} {percent(table[-1, index])}", (1.02, ends[place]),
            xycoords=("axes fraction", "data"), color=colour, va="center", annotation_clip=False,
            fontweight="bold" if place == 0 else "normal",
        )  # fmt: skip


def _spread_labels(heights: NDArray[np.floating], gap: float) -> NDArray[np.float64]:
    """Heights at least `gap` apart, near the given ones; computed in a single sweep."""
    order = np.argsort(heights)
    spread = np.array(heights, dtype=np.float64)
    for lower, upper in pairwise(order):
        spread[upper] = max(spread[upper], spread[lower] + gap)
    return spread
