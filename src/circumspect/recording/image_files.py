"""Depth and colour images of recordings."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.sensing.picture import opened_picture

MOST_PIXELS = 4096
"""Along a side."""
FORMATS = ("PNG", "JPEG")
"""Of colour images."""

_log = logging.getLogger(__name__)


def read_depth(file: Path) -> NDArray[np.uint16]:
    """Read a 16 bit PNG.

    Raises:
        InputError: Missing, broken, or no 16 bit PNG.
    """
    with opened_picture(file, ("PNG",), MOST_PIXELS) as image:
        if image.mode not in ("I;16", "I", "I;16B"):
            raise InputError(f"{file}: is no 16 bit depth image but {image.mode}")
        return np.asarray(image).astype(np.uint16)


def read_colour(
    file: Path, size: tuple[int, int], other_size_is_usual: bool = False
) -> NDArray[np.uint8] | None:
    """Read a colour image that only adorns a frame: a broken one is logged and left out.

    Args:
        file: The image.
        size: Width and height that it must have.
        other_size_is_usual: Images of another size are left out without a word.

    Returns:
        (height, width, 3) RGB, or None.
    """
    try:
        with opened_picture(file, FORMATS, MOST_PIXELS) as image:
            if image.size == size:
                return np.asarray(image.convert("RGB"))
            if not other_size_is_usual:
                _log.warning("colour left out: %s: is %s, the depth %s", file, image.size, size)
    except InputError as error:
        _log.warning("colour left out: %s", error)
    return None
