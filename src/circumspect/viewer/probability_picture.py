"""Picture of the class probabilities over the frames, as stacked bars with axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.recognition import FrameOutcome
from circumspect.viewer.colouring import CLASSES

WIDTH, HEIGHT, FOOT = 312, 84, 8
"""Size of the bars [px]; the foot marks frames without an answer."""
LEFT, RIGHT, TOP, BOTTOM = 38, 10, 7, 18
"""Margins for the axes [px]."""
FONT_SIZE, MOST_TICKS, FEWEST_FRAMES = 11, 6, 20
EMPTY, FAULT, INK = (241, 245, 249), (185, 28, 28), (71, 85, 105)


def probability_picture(
    rows: Sequence[Mapping[str, Any]], count: int, total: int | None = None
) -> NDArray[np.uint8]:
    """Draw stacked bars over the frame number, with ticks for probabilities and frames.

    Args:
        rows: See `DashboardState.rows`.
        count: Number of rows to use.
        total: Number of frames in the width; None means `count`.

    Returns:
        (height, width, 3) RGB.
    """
    frames = max(count, total or 0, FEWEST_FRAMES)
    picture = _axes(frames).copy()
    picture[TOP : TOP + HEIGHT + FOOT, LEFT : LEFT + WIDTH] = probability_bars(rows, count, frames)
    return picture


def probability_bars(
    rows: Sequence[Mapping[str, Any]], count: int, frames: int
) -> NDArray[np.uint8]:
    """Draw a column of stacked bars per frame, the oldest on the left.

    Args:
        rows: See `DashboardState.rows`.
        count: Number of rows to use.
        frames: Number of frames in the width.

    Returns:
        (HEIGHT + FOOT, WIDTH, 3) RGB.
    """
    picture = np.empty((HEIGHT + FOOT, WIDTH, 3), np.uint8)
    picture[:] = EMPTY
    columns = np.arange(WIDTH) * frames // WIDTH
    for frame in np.unique(columns[columns < count]):
        mine = columns == frame
        row = rows[frame]
        if row.get("outcome") != FrameOutcome.CLASSIFIED:
            picture[HEIGHT:, mine] = FAULT
        if row.get("probabilities"):
            picture[:HEIGHT, mine] = _column(row["probabilities"])[:, None]
    return picture


def frame_ticks(frames: int) -> list[int]:
    """Round numbers of frames for the axis: 1, 2 or 5 times a power of ten apart."""
    steps = (factor * 10**power for power in range(9) for factor in (1, 2, 5))
    step = next(step for step in steps if frames // step <= MOST_TICKS)
    return list(range(step, frames + 1, step))


@lru_cache(maxsize=4)
def _axes(frames: int) -> NDArray[np.uint8]:
    """The picture without its bars."""
    from PIL import Image, ImageDraw, ImageFont

    size = (LEFT + WIDTH + RIGHT, TOP + HEIGHT + FOOT + BOTTOM)
    picture = Image.new("RGB", size, "white")
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(FONT_SIZE)
    for share in (0, 50, 100):
        y = TOP + HEIGHT - HEIGHT * share // 100
        draw.line([(LEFT - 4, y), (LEFT, y)], fill=INK)
        draw.text((LEFT - 6, y), f"{share} %", fill=INK, font=font, anchor="rm")
    below = TOP + HEIGHT + FOOT
    draw.text((LEFT - 6, below + 5), "frame", fill=INK, font=font, anchor="rt")
    for frame in frame_ticks(frames):
        x = LEFT + (2 * frame - 1) * WIDTH // (2 * frames)
        draw.line([(x, below), (x, below + 3)], fill=INK)
        draw.text((x, below + 5), f"{frame}", fill=INK, font=font, anchor="mt")
    return np.asarray(picture)


def _column(probabilities: Mapping[str, float]) -> NDArray[np.uint8]:
    """(HEIGHT, 3) RGB of a column, the first class at the bottom."""
    ends = HEIGHT * np.cumsum(list(probabilities.values()))
    classes = np.searchsorted(ends, np.arange(HEIGHT) + 0.5).clip(0, len(probabilities) - 1)
    return CLASSES[classes[::-1] % len(CLASSES)]
