"""Depth and colour images of recordings."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.recording.regular_file import require_regular

MOST_PIXELS = 4096
"""Along a side; a small file can hold a huge picture of one colour."""
FORMATS = ("PNG", "JPEG")
"""Of colour images. Pillow knows more, and hands some of them to other programs."""

_log = logging.getLogger(__name__)


def read_depth(file: Path) -> NDArray[np.uint16]:
    """Read a 16 bit PNG.

    Raises:
        InputError: Missing, broken, or no 16 bit PNG.
    """
    from PIL import Image

    try:
        require_regular(file)
        with Image.open(file, formats=("PNG",)) as image:
            if max(image.size) > MOST_PIXELS:
                raise InputError(f"{file}: has {image.size[0]} x {image.size[1]} pixels; "
                                 f"{MOST_PIXELS} along a side are read")  # fmt: skip
            if image.mode not in ("I;16", "I", "I;16B"):
                raise InputError(f"{file}: is no 16 bit depth image but {image.mode}")
            return np.asarray(image).astype(np.uint16)
    # Pillow reports broken files by any of these.
    except (
        OSError,
        ValueError,
        SyntaxError,
        Image.DecompressionBombError,
        Image.DecompressionBombWarning,
    ) as error:
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
        require_regular(file)
        with Image.open(file, formats=FORMATS) as image:
            if image.size == size:
                return np.asarray(image.convert("RGB"))
            _log.warning("colour left out: %s: is %s, the depth %s", file, image.size, size)
    except (
        OSError,
        ValueError,
        SyntaxError,
        Image.DecompressionBombError,
        Image.DecompressionBombWarning,
    ) as error:
        _log.warning("colour left out: %s: %s", file, error)
    return None
