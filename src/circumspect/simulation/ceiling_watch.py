"""The intelligent space beside a simulated robot: sees it at every frame, and tells it nothing."""

from __future__ import annotations

from collections.abc import Callable

from circumspect.localization import CeilingImage, IntelligentSpace, SpaceFix, SpaceTrack
from circumspect.simulation.ceiling_rig import CeilingRig
from circumspect.simulation.simulated_robot import Truth


class CeilingWatch:
    """Takes images and keeps what the intelligent space makes of them; see `Witness.others`.

    Attributes:
        listeners: Are given every image, too.
    """

    def __init__(self, rig: CeilingRig, space: IntelligentSpace) -> None:
        """Begin with nothing seen.

        Args:
            rig: The cameras as they hang in truth.
            space: The cameras as they were calibrated.
        """
        self.rig, self.space = rig, space
        self.listeners: tuple[Callable[[CeilingImage], None], ...] = ()
        self._fixes: list[SpaceFix] = []

    def __call__(self, truth: Truth) -> None:
        """See the robot now."""
        images = self.rig.images(truth)
        for listener in self.listeners:
            for image in images:
                listener(image)
        self._fixes.append(self.space.locate(images))

    @property
    def track(self) -> SpaceTrack:
        """What was seen so far."""
        return SpaceTrack.of(self._fixes, self.space.reports)
