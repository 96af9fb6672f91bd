"""The summary picture of a run."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from circumspect.classification.answer_text import truth_text
from circumspect.errors import MissingExtraError
from circumspect.geometry.point_cloud import MAX_SHOWN_POINTS
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.runs.panels import draw_probabilities, draw_shares, draw_side
from circumspect.runs.plan_panel import draw_plan
from circumspect.runs.run_path import RunPath
from circumspect.storage import atomic_path

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIDES = (("−y", -90.0, 12.0), ("+x", 0.0, 12.0), ("above, at a slant", -60.0, 50.0))
"""Name, azimuth and elevation [degrees] of the views of the model."""


def draw_run(
    path: str | os.PathLike[str],
    result: RecognitionResult,
    config: Mapping[str, Any],
    run_path: RunPath | None = None,
    why_missed: Sequence[str] = (),
    completeness: Mapping[str, float] | None = None,
) -> None:
    """Draw plan view, model from three sides, grid and probabilities.

    Args:
        path: The PNG to write.
        result: A run with a grid of the object; may have no answer.
        config: Configuration of the run; "truth" and "start_deg", if given, are in the subtitle.
        run_path: The path of the robot.
        why_missed: The reason of each missed view; empty if unknown.
        completeness: Modelled fractions of the true surface, by name; None or empty if the truth is
            unknown.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OutputError: The file cannot be written.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", "figures") from error
    figure = Figure(figsize=(16, 9.6), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    _arrange(figure, result, config, run_path or RunPath(), why_missed, completeness or {})
    with atomic_path(path) as aside:
        figure.savefig(aside, format="png")


def _arrange(
    figure: Figure,
    result: RecognitionResult,
    config: Mapping[str, Any],
    run_path: RunPath,
    why_missed: Sequence[str],
    completeness: Mapping[str, float],
) -> None:
    last = result.last
    if last is None or last.grid is None:
        raise ValueError("a run without a grid has no picture")
    cloud = last.model.cloud().thinned(MAX_SHOWN_POINTS)
    title, note = captions(result, config)
    heading = figure.text(0.035, 0.957, title, fontsize=21, fontweight="bold", va="center")
    # Bars are to the right of it.
    too_wide = heading.get_window_extent().width / (0.61 * figure.bbox.width)
    heading.set_fontsize(21 / max(1.0, too_wide))
    figure.text(0.035, 0.922, note, fontsize=12.5, color="0.35", va="center")
    shares = {"azimuth covered": last.coverage, **(completeness or {"surface modelled": None})}
    draw_shares(figure.add_axes((0.77, 0.9, 0.135, 0.026 * len(shares))), shares)
    plan = figure.add_axes((0.055, 0.235, 0.36, 0.62))
    draw_plan(plan, cloud, result, run_path, why_missed)
    sides = figure.add_gridspec(1, 3, left=0.475, right=0.985, bottom=0.53, top=0.855, wspace=0.08)
    for column, (name, azimuth, elevation) in enumerate(SIDES):
        draw_side(figure.add_subplot(sides[0, column]), cloud, name, azimuth, elevation)
    last.grid.plot(figure.add_axes((0.5, 0.085, 0.2, 0.335)))
    draw_probabilities(figure.add_axes((0.765, 0.085, 0.14, 0.335)), result, run_path)


def captions(result: RecognitionResult, config: Mapping[str, Any]) -> tuple[str, str]:
    """The title and the subtitle of the picture."""
    last = result.last
    if last is None:
        return "no answer", ""
    parts = [f"{len(result.steps)} frames"]
    if config.get("start_deg") is not None:
        parts.insert(0, f"started at azimuth {config['start_deg']:.0f}°")
    prediction, truth = last.prediction, config.get("truth")
    if prediction is not None and truth is not None:
        judged = truth_text(prediction.label, prediction.in_distribution, truth)
        parts.insert(0, judged.replace("_", " "))
    if result.lost_from is not None:
        parts.append(f"lost from frame {result.lost_from} on")
    if result.interrupted:
        parts.append("interrupted")
    return _title(last), ", ".join(parts)


def _title(last: RecognitionStep) -> str:
    prediction = last.prediction
    if prediction is None:
        return "no answer"
    state = "confident" if last.confident else "not confident"
    return f"{prediction.text}, {state}".replace("_", " ")
