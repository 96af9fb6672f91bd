"""What a ceiling camera hands over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError


@dataclass(frozen=True, eq=False)
class CeilingImage:
    """One grey image.

    Attributes:
        camera: The camera's name.
        stamp: Time of the middle of its exposure [s].
        grey: (height, width) uint8.

    Raises:
        InputError: It is no grey image of 8 bits, or has no time.
    """

    camera: str
    stamp: float
    grey: NDArray[np.uint8]

    def __post_init__(self) -> None:
        if self.grey.ndim != 2 or self.grey.dtype != np.uint8:
            raise InputError(
                f"camera '{self.camera}': images are grey, (height, width) uint8, not "
                f"{self.grey.shape} {self.grey.dtype}"
            )
        if not np.isfinite(self.stamp):
            raise InputError(f"camera '{self.camera}': an image has no time: {self.stamp}")
