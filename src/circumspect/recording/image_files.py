"""Depth and colour images of recordings."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError

_log = logging.getLogger(__name__)


def read_depth(file: Path) -> NDArray[np.uint16]:
    """Read a 16 bit PNG.

    Raises:
        InputError: Missing, broken, or no 16 bit PNG.
    """
    from PIL import Image

    try:
        with Image.open(file) as image:
            if image.format != "PNG" or image.mode not in ("I;16", "I", "I;16B"):
                raise InputError(f"{file}: is no 16 bit depth image but {image.mode}")
            return np.asarray(image).astype(np.uint16)
    # Pillow reports broken files by any of these.
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InputError(f"{file}: can not be read ({error})") from error


def read_colour(file: Path, size: tuple[int, int]) -> NDArray[np.uint8] | None:
    """Read a colour image that only adorns a frame: a broken one is logged and left out.

    Args:
        file: The image.
        size: Width and height that it must have.

    Returns:
        (height, width, 3) RGB, or None.
    """
    from PIL import Image

    try:
        with Image.open(file) as image:
            if image.size == size:
                return np.asarray(image.convert("RGB"))
            _log.warning("colour left out: %s: is %s, the depth %s", file, image.size, size)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        _log.warning("colour left out: %s: %s", file, error)
    return None
