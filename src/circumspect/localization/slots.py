"""Images of one time, put together from a stream of all cameras."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from circumspect.localization.ceiling_image import CeilingImage


def slots(images: Iterable[CeilingImage], spread: float) -> Iterator[tuple[CeilingImage, ...]]:
    """Group images in the order in which they come; at most one a camera in each group.

    Args:
        images: Of all cameras, in the order of arrival: from a folder, a bag or live.
        spread: Stamps of one group differ by no more than this [s].
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
