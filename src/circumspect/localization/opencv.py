"""OpenCV where it is needed, and a clear word where it is missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from circumspect.errors import MissingExtraError


def opencv() -> Any:
    """The module `cv2`.

    Raises:
        MissingExtraError: It is not installed.
    """
    try:
        return import_module("cv2")
    except ImportError as error:
        raise MissingExtraError("opencv-python-headless", "locate") from error
