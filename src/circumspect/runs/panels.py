"""Panels of a run's picture, drawn into given axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.answer_text import percent
from circumspect.figure_canvas import INK
from circumspect.geometry import PointCloud
from circumspect.recognition import RecognitionResult
from circumspect.recognition.answer_plot import CLASS_COLOURS, draw_answers
from circumspect.runs.run_path import RunPath, camera_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MIN_PATH_M = 0.05
"""A camera that moved less than this stood still [m]."""


def draw_side(
    axes: Axes, cloud: PointCloud, name: str, azimuth_deg: float, elevation_deg: float
) -> None:
    """Draw the model in parallel projection.

    Args:
        axes: Axes to draw into.
        cloud: The model.
        name: Title.
        azimuth_deg: Azimuth of the viewer as seen from the model [degrees].
        elevation_deg: Elevation of the viewer above the horizon [degrees].
    """
    cloud.plot(axes, azimuth_deg, elevation_deg)
    axes.set_title(f"Model, from {name}", loc="left", color=INK)


def draw_shares(axes: Axes, shares: Mapping[str, float | None]) -> None:
    """Draw fractions as labelled bars.

    Args:
        axes: Axes to draw into; the names are on the left.
        shares: Fractions by name, 0 to 1; None for unknown ones.
    """
    for row, share in enumerate(shares.values()):
        axes.barh(row, 1.0, 0.62, color="0.92")
        if share is not None:
            axes.barh(row, share, 0.62, color=CLASS_COLOURS[0])
        text = "unknown without the true shape" if share is None else percent(share)
        place, colour = (0.03, "0.4") if share is None else (1.03, INK)
        axes.text(place, row, text, va="center", color=colour, fontsize=9 if share is None else 11)
    axes.set(xlim=(0, 1), ylim=(len(shares) - 0.5, -0.5), xticks=[])
    axes.set_yticks(range(len(shares)), list(shares), color=INK)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)


def draw_probabilities(axes: Axes, result: RecognitionResult, run_path: RunPath) -> None:
    """Draw the probabilities of the leading classes over the distance; see `draw_answers`."""
    draw_answers(axes, *result.answers, *_progress(result, run_path))


def _progress(result: RecognitionResult, run_path: RunPath) -> tuple[NDArray[np.float64], str]:
    """(n,) progress of the run at each step, and its label."""
    stamps = np.array([step.stamp for step in result.steps])
    driven = run_path.driven_by(stamps)
    if driven is not None:
        return driven, "distance driven [m]"
    path = camera_path(result)
    if path is not None and len(path) > 1:
        steps = np.linalg.norm(np.diff(path.positions_xyz, axis=0), axis=1)
        if steps.sum() > MIN_PATH_M:
            far = np.interp(stamps, path.stamps, np.concatenate([[0.0], np.cumsum(steps)]))
            return far, "path of the camera [m]"
    return np.arange(1.0, len(stamps) + 1.0), "frame"
