"""Pictures of several networks beside each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from circumspect.evaluation.figure_canvas import new_figure
from circumspect.evaluation.yaw_sweep import YawSweep

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
    """Accuracy over the yaw of the object, a line a network.

    Args:
        sweeps: By the name in the legend.
        trained_at: The title.
    """
    further = max(0, -(-len(sweeps) // LEGEND_COLUMNS) - 4)
    figure = new_figure((9, 5 + LEGEND_ROW * further))
    axes = figure.add_subplot()
    for number, (name, sweep) in enumerate(sweeps.items()):
        order = np.argsort(sweep.yaw_deg)
        axes.plot(
            sweep.yaw_deg[order],
            100 * sweep.accuracy[order],
            STYLES[number // len(COLOURS) % len(STYLES)],
            color=COLOURS[number % len(COLOURS)],
            label=f"{name}: worst {100 * sweep.accuracy.min():.1f} %",
            marker=".",
        )
    axes.set_xlabel("yaw of the object [°]")
    axes.set_ylabel("accuracy [%]")
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 45))
    axes.set_ylim(0, 100)
    axes.grid(alpha=0.3)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=LEGEND_COLUMNS, frameon=False
    )
    axes.set_title(trained_at.capitalize(), fontsize=11)
    return figure
