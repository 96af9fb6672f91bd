"""Figures that compare several networks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from circumspect.evaluation.yaw_sweep import YawSweep
from circumspect.figure_canvas import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = ("#b8402a", "#e0a030", "#5a9bb0", "#14506a", "#6a8f3c", "#8a5a9a", "#777777", "#202020")
STYLES = ("-", "--")
LEGEND_COLUMNS = 2
LEGEND_ROW = 0.22
"""Height of a row beyond the fourth [inch]."""


def draw_accuracies_over_yaw(
    sweeps: Mapping[str, YawSweep], trained_at: str = "trained at 0° alone"
) -> Figure:
    """Draw accuracy over the yaw of the object, one line per network.

    Args:
        sweeps: Name in the legend to sweep.
        trained_at: Title.
    """
    further = max(0, -(-len(sweeps) // LEGEND_COLUMNS) - 4)
    figure = new_figure((9, 5 + LEGEND_ROW * further))
    axes = figure.add_subplot()
    for number, (name, sweep) in enumerate(sweeps.items()):
        colour, style = COLOURS[number % len(COLOURS)], STYLES[number // len(COLOURS) % len(STYLES)]
        sweep.plot(axes, name, color=colour, linestyle=style)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=LEGEND_COLUMNS, frameon=False
    )
    axes.set_title(trained_at.capitalize(), fontsize=11)
    return figure
