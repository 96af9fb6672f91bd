"""Several fixed cameras that say where the robot is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from circumspect.errors import InputError
from circumspect.localization.ceiling_image import CeilingImage
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.leap_guard import CONFIRMED, LeapGuard
from circumspect.localization.sighting import Sighting
from circumspect.localization.slots import slots
from circumspect.localization.space_fix import SpaceFix
from circumspect.localization.space_settings import SpaceSettings
from circumspect.localization.space_tracker import SpaceTracker
from circumspect.localization.tag_mount import TagMount
from circumspect.localization.tag_watch import TagWatch

BEHIND = 1.0
"""Stamps so far behind the latest fix [s] are believed after a few of them in a row."""
MOST_WAITING = 30
"""So many times wait at most for those that tell whether their stamps can be believed."""


class IntelligentSpace:
    """Detects the tag in every image, and fuses what the cameras see."""

    def __init__(
        self,
        cameras: Sequence[FixedCamera],
        mount: TagMount | None = None,
        settings: SpaceSettings | None = None,
    ) -> None:
        """Set up a detector for each camera.

        Args:
            cameras: Calibrated, any number.
            mount: The tag on the robot.
            settings: See `SpaceSettings`.

        Raises:
            InputError: No camera, or two of one name.
            MissingExtraError: pupil-apriltags is not installed.
        """
        names = [camera.name for camera in cameras]
        if not names or len(set(names)) < len(names):
            raise InputError(f"cameras with different names are needed, not {names}")
        self.mount, self.settings = mount or TagMount(), settings or SpaceSettings()
        self._watches = {c.name: TagWatch(c, self.mount, self.settings) for c in cameras}
        self._tracker = SpaceTracker(self.settings)
        self._guard = LeapGuard(self._watches)
        self._behind = 0
        self._set_back: list[str] = []
        self._pool = ThreadPoolExecutor(min(self.settings.workers, len(names)))

    @property
    def reports(self) -> tuple[str, ...]:
        """Sentences about cameras that moved since calibration, and clocks that were set back."""
        return (*self._tracker.watch.reports, *self._set_back)

    def track(self, images: Iterable[CeilingImage]) -> Iterator[SpaceFix]:
        """A fix for the images of each time, in the order of arrival.

        Images whose stamps leap ahead wait until those that follow tell whether they can be
        believed: then they are fixes like others, and else such of the time before, with the
        reason.

        Args:
            images: Of all cameras, in the order of arrival.
        """
        waiting: list[Sequence[CeilingImage]] = []
        for slot in slots(images, self.settings.slot):
            until = self._guard.until(slot, self._tracker.stamp)
            waiting.append(slot)
            leaps = max(image.stamp for image in slot) > until
            if not leaps or len(waiting) >= MOST_WAITING:
                yield from (self._located(held, until) for held in waiting)
                waiting = []
        until = self._guard.until_the_end(self._tracker.stamp)
        yield from (self._located(held, until) for held in waiting)

    def locate(self, images: Sequence[CeilingImage]) -> SpaceFix:
        """Where the robot is by the images of one time.

        Args:
            images: At least one, at most one a camera. Cameras that are not calibrated, images
                that come late, stamps that leap ahead and tags that can not be are left out, with
                the reason. A leap of all cameras at once is believed, another one the third time.

        Returns:
            The fix; where all images come late, that of the time before, with the reasons.

        Raises:
            InputError: No image.
        """
        if not images:
            raise InputError("there is no image to see the robot in")
        return self._located(images, self._guard.until(images, self._tracker.stamp))

    def _located(self, images: Sequence[CeilingImage], until: float) -> SpaceFix:
        """See `locate`; stamps later than `until` [s] are leaps."""
        self._begin_anew_if_set_back(max(image.stamp for image in images))
        after = self._tracker.stamp
        sightings = list(self._pool.map(lambda image: self._look(image, after, until), images))
        fresh = [s.stamp for s in sightings if after < s.stamp <= until]
        return self._tracker.take(float(np.median(fresh)) if fresh else after, sightings)

    def _begin_anew_if_set_back(self, newest: float) -> None:
        """Else every image would come too late, and the robot stay where it was last seen."""
        back = self._tracker.stamp - newest
        self._behind = self._behind + 1 if back > BEHIND else 0
        if self._behind < CONFIRMED:
            return
        self._behind = 0
        self._set_back.append(f"the cameras' clock was set back by {back:.1f} s at {newest:.3f} s")
        self._tracker.begin_anew()
        for watch in self._watches.values():
            watch.begin_anew()

    def _look(self, image: CeilingImage, after: float, until: float) -> Sighting:
        if image.stamp > until:
            ahead = f"by {image.stamp - after:.1f} s"
            return Sighting(image.camera, image.stamp, reason="its stamp leaps ahead", detail=ahead)
        watch = self._watches.get(image.camera)
        if watch is None:
            known = ", ".join(self._watches)
            reason = f"no calibration of this camera; known: {known}"
            return Sighting(image.camera, image.stamp, reason=reason)
        return watch.look(image, after)
