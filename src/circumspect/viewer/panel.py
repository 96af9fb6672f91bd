"""The panel beside the 3D view: results, images and controls."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.runs.playback_moment import thinned
from circumspect.viewer.colouring import COLOURINGS, depth_picture
from circumspect.viewer.dashboard_state import DashboardState, FrameImages
from circumspect.viewer.panel_html import (
    answer_html,
    bars_html,
    faults_html,
    legend_html,
    times_html,
)
from circumspect.viewer.probability_picture import probability_picture
from circumspect.viewer.stage import LAYERS
from circumspect.viewer.turned_object import TurnedObject

if TYPE_CHECKING:
    import viser

IMAGE_WIDTH = 240
"""Width of each of the two images [px]."""
YAW_STEP = 1.0
"""Step of the yaw slider [degrees]."""


class Panel:
    """The viser controls that all dashboards share.

    Attributes:
        tabs: Group of tabs, to which live and finished runs add their own.
        turn: Slider that rotates the object [degrees].
        colouring: Selection of the object's colours.
        explain_now: Button that requests an explanation.
        layers: Checkboxes by name of the layer.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        """Add an empty panel to a server's page."""
        gui = server.gui
        self._server = server
        self._shown_html: dict[str, str] = {}
        self._answer = gui.add_html(answer_html({}))
        self._bars = gui.add_html(bars_html(None))
        self._history = gui.add_image(
            probability_picture([], 0), label="Probabilities over the frames", format="png"
        )
        gui.add_html(legend_html())
        self.tabs = gui.add_tab_group()
        with self.tabs.add_tab("Turn"):
            self.turn = gui.add_slider("turn [°]", 0.0, 360.0, YAW_STEP, 0.0)
            self._turned = gui.add_html("")
            self._show_turned(None)
        with self.tabs.add_tab("Camera"):
            self._images = gui.add_image(_blank(), label="Depth and colour", format="jpeg")
        with self.tabs.add_tab("Why"):
            self.explain_now = gui.add_button(
                "Explain the answer", hint="colours the object by class evidence"
            )
            self._why = gui.add_html("")
        with self.tabs.add_tab("Look"):
            self.colouring = gui.add_dropdown("colour", COLOURINGS)
            self.layers = {
                name: gui.add_checkbox(name, initial_value=visible)
                for name, visible in LAYERS.items()
            }
        with self.tabs.add_tab("Stages"):
            self._coverage = gui.add_progress_bar(0.0)
            self._times = gui.add_html("")
            self._faults = gui.add_html("")

    def explain(self, text: str) -> None:
        """Show an explanation, HTML."""
        self._show_html("why", self._why, text)

    def show(
        self, state: DashboardState, turned: TurnedObject | None, total: int | None = None
    ) -> None:
        """Show a state.

        Args:
            state: The state.
            turned: The object rotated by the slider; None without rotation.
            total: Number of frames in the width of the history.
        """
        row = state.row
        self._show_html("answer", self._answer, answer_html(row, state.truth, state.message))
        self._show_html("bars", self._bars, bars_html(row.get("probabilities")))
        self._show_html("times", self._times, times_html(row))
        self._show_html("faults", self._faults, faults_html(state.rows, state.count))
        self._coverage.value = 100.0 * float(row.get("coverage", 0.0))
        self._history.image = probability_picture(state.rows, state.count, total)
        if state.images is not None:
            self._images.image = images_side_by_side(state.images)
        elif state.count == 0:
            self._images.image = _blank()
        self._show_turned(turned, row.get("label"))

    def _show_turned(self, turned: TurnedObject | None, label: str | None = None) -> None:
        if turned is None:
            text = (
                "<div style='padding:.2em 1em;font-size:.85em'>Turn the object: its grid is made "
                "again from the turned points, and classified again.</div>"
            )
        else:
            p = turned.prediction
            text = answer_html(
                {
                    "label": p.label,
                    "probability": p.probability,
                    "in_distribution": p.in_distribution,
                    "alternatives": p.alternatives,
                },
                message=f"turned by {np.degrees(turned.yaw):.0f}°: "
                + ("the answer stays" if p.label == label else f"it was {label}"),
            ).replace("circumspect-label", "circumspect-turned")
        self._show_html("turned", self._turned, text)

    def _show_html(self, name: str, handle: viser.GuiHtmlHandle, text: str) -> None:
        """Send the text if it changed."""
        if self._shown_html.get(name) != text:
            self._shown_html[name] = text
            handle.content = text


def images_side_by_side(images: FrameImages) -> NDArray[np.uint8]:
    """Depth and colour image side by side, each about `IMAGE_WIDTH` wide."""
    depth = depth_picture(thinned(images.depth, IMAGE_WIDTH))
    if images.colour is None:
        return depth
    colour = thinned(images.colour, IMAGE_WIDTH)
    gap = np.full((len(depth), 4, 3), 255, np.uint8)
    return np.hstack([depth, gap, colour])


def _blank() -> NDArray[np.uint8]:
    return np.full((IMAGE_WIDTH * 3 // 8, IMAGE_WIDTH, 3), 241, np.uint8)
