"""Images of ceiling cameras, and their grouping by time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError


@dataclass(frozen=True, eq=False)
class CeilingImage:
    """A grey image.

    Attributes:
        camera: The camera's name.
        stamp: Time of the middle of the exposure [s].
        grey: (height, width) uint8.

    Raises:
        InputError: The image is not grey with 8 bits, or has no time.
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


def slots(images: Iterable[CeilingImage], spread: float) -> Iterator[tuple[CeilingImage, ...]]:
    """Group simultaneous images; each group has at most one per camera.

    Args:
        images: Images of all cameras, in the order of arrival: from a folder, a bag or live.
        spread: Maximum difference of the stamps of a group [s].
    """
    waiting: list[CeilingImage] = []
    for image in images:
        apart = waiting and abs(image.stamp - waiting[0].stamp) > spread
        if apart or any(image.camera == other.camera for other in waiting):
            yield tuple(waiting)
            waiting = []
        waiting.append(image)
    if waiting:
        yield tuple(waiting)
