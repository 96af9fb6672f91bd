"""Colours for evidence: red speaks for the class, blue against it, light grey neither."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_PLACES = (-1.0, -0.5, 0.0, 0.5, 1.0)
_COLOURS = np.array(
    [(20, 60, 150), (95, 150, 215), (222, 222, 220), (235, 130, 75), (165, 15, 25)], float
)
PERCENTILE = 99.0
"""Of the strengths that the full colours stand for: single cells may lie beyond."""


def evidence_span(values: NDArray[np.floating]) -> float:
    """The strength that the full colours stand for, never 0.

    Args:
        values: Evidence of any shape.
    """
    strengths = np.abs(values[values != 0])
    return float(np.percentile(strengths, PERCENTILE)) if strengths.size else 1.0


def evidence_colours(values: NDArray[np.floating], span: float) -> NDArray[np.uint8]:
    """The colour of each value.

    Args:
        values: Evidence of any shape.
        span: From -span to span the colours change, beyond they stay.

    Returns:
        (*shape, 3) uint8 red, green, blue.
    """
    scaled = np.clip(np.asarray(values, float) / span, -1.0, 1.0)
    channels = [np.interp(scaled, _PLACES, _COLOURS[:, channel]) for channel in range(3)]
    return np.rint(np.stack(channels, axis=-1)).astype(np.uint8)
