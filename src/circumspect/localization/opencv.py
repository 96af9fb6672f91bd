"""Import of OpenCV with a clear error if it is missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from circumspect.errors import MissingExtraError


def opencv() -> Any:
    """Import `cv2`.

    Raises:
        MissingExtraError: It is not installed.
    """
    try:
        return import_module("cv2")
    except ImportError as error:
        raise MissingExtraError("opencv-python-headless", "locate") from error
