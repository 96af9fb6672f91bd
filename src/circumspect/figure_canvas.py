"""Figures without a display."""

from __future__ import annotations

from typing import TYPE_CHECKING

from circumspect.errors import MissingExtraError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ACCENT, INK = "#1f6f8b", "0.25"
"""Colours of what is shown and of its titles."""


def new_figure(size: tuple[float, float]) -> Figure:
    """An empty figure.

    Args:
        size: (width, height) [inch].

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", "figures") from error
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def axes_or_new(axes: Axes | None, size: tuple[float, float] = (6.4, 4.0)) -> Axes:
    """The axes that were given, or those of a new figure; the `plot` methods draw into them.

    Args:
        axes: Where to draw; None for a new figure, which is the `figure` of the result.
        size: (width, height) of a new figure [inch].

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    return new_figure(size).add_subplot() if axes is None else axes
