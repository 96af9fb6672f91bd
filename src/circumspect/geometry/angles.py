"""Angles."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Angle = TypeVar("Angle", float, NDArray[np.floating])


def wrapped(angle: Angle) -> Angle:
    """The same direction [rad] within ± π."""
    return (angle + np.pi) % (2 * np.pi) - np.pi
