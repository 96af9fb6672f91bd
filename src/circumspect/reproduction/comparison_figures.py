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


def draw_accuracies_over_yaw(sweeps: Mapping[str, YawSweep]) -> Figure:
    """Accuracy over the yaw of the object, a line a network."""
    figure = new_figure((9, 5))
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
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2, frameon=False)
    axes.set_title("Trained at 0° alone", fontsize=11)
    return figure
