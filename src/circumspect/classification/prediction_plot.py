"""Draws a prediction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from circumspect.classification.answer_text import percent
from circumspect.figure_canvas import ACCENT, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_CLASSES = 12
BOUND = "#b8402a"


def draw_probabilities(
    axes: Axes, probabilities: Mapping[str, float], bound: float | None, title: str
) -> None:
    """A bar a class, the most probable on top, and the bound of a confident answer.

    Args:
        axes: Where to draw.
        probabilities: Class to probability; the `MOST_CLASSES` most probable ones are shown.
        bound: The least probability of a confident answer; none is drawn for None or above 1.
        title: Above the bars.
    """
    ranked = sorted(probabilities.items(), key=lambda item: -item[1])[:MOST_CLASSES]
    for row, (_, share) in enumerate(ranked):
        axes.barh(row, 100 * share, 0.7, color=ACCENT, alpha=1.0 if row == 0 else 0.5)
        axes.text(100 * share + 1, row, percent(share), va="center", color=INK, fontsize=9)
    if bound is not None and bound <= 1.0:
        label = f"confident from {percent(bound)}"
        axes.axvline(100 * bound, color=BOUND, lw=1.2, ls="--", label=label)
        axes.legend(loc="lower right", framealpha=1.0, edgecolor="none", fontsize=9)
    axes.set_yticks(range(len(ranked)), [name.replace("_", " ") for name, _ in ranked])
    axes.set(xlim=(0, 108), xlabel="probability [%]")
    axes.set_xticks(range(0, 101, 20))
    axes.invert_yaxis()
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(title, loc="left", color=INK, fontsize=10)
