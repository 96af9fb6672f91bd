"""Probabilities over time as stacked bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.recognition import FrameOutcome
from circumspect.viewer.colouring import CLASSES

WIDTH, HEIGHT, FOOT = 360, 90, 8
"""[px]; the foot marks frames that led to no answer."""
EMPTY, FAULT = (241, 245, 249), (185, 28, 28)


def probability_picture(
    rows: Sequence[Mapping[str, Any]], count: int, total: int | None = None
) -> NDArray[np.uint8]:
    """One column of stacked bars a frame, the classes in their colours, oldest left.

    Args:
        rows: See `Shown.rows`.
        count: How many of them.
        total: As many frames fill the width; None means `count`.

    Returns:
        (HEIGHT + FOOT, WIDTH, 3) RGB.
    """
    picture = np.empty((HEIGHT + FOOT, WIDTH, 3), np.uint8)
    picture[:] = EMPTY
    if count == 0:
        return picture
    wide = max(count, total or 0, 20)
    columns = np.arange(WIDTH) * wide // WIDTH
    for frame in np.unique(columns[columns < count]):
        mine = columns == frame
        row = rows[frame]
        if row.get("outcome") != FrameOutcome.CLASSIFIED:
            picture[HEIGHT:, mine] = FAULT
        if row.get("probabilities"):
            picture[:HEIGHT, mine] = _column(row["probabilities"])[:, None]
    return picture


def _column(probabilities: Mapping[str, float]) -> NDArray[np.uint8]:
    """(HEIGHT, 3): the first class at the bottom."""
    ends = HEIGHT * np.cumsum(list(probabilities.values()))
    classes = np.searchsorted(ends, np.arange(HEIGHT) + 0.5).clip(0, len(probabilities) - 1)
    return CLASSES[classes[::-1] % len(CLASSES)]
