"""Localisation of the robot by several fixed cameras."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from circumspect.errors import InputError
from circumspect.localization.ceiling_image import CeilingImage, slots
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.space_fix import Sighting, SpaceFix
from circumspect.localization.space_settings import SpaceSettings
from circumspect.localization.space_tracker import SpaceTracker
from circumspect.localization.tag_mount import TagMount
from circumspect.localization.tag_observer import TagObserver

MIN_SETBACK_S = 1.0
"""Stamps this far behind the latest fix are accepted after several consecutive ones [s]."""
MAX_PENDING = 30
"""Maximum number of times that wait for the confirmation of their stamps."""
MAX_JUMP_S = 10.0
"""Stamps this far ahead of the latest fix are a jump, unless images are usually this sparse [s]."""
MIN_CONFIRMATIONS = 3
"""Number of consecutive, increasing stamps that confirm a jump."""
MIN_FINAL_CONFIRMATIONS = 2
"""The same number at the end of the images."""
SPACING_FACTOR = 2.0
"""Multiple of the usual spacing of images that is no jump."""


class ClockJumpFilter:
    """Rejects jumps of a camera's clock, which would make all later images late."""

    def __init__(self, cameras: Iterable[str]) -> None:
        """Start with the expectation of closely spaced images.

        Args:
            cameras: Names of all cameras.
        """
        self._cameras = frozenset(cameras)
        self._row: list[float] = []
        self._max_jump_s = MAX_JUMP_S
        self._followed = False

    def update(self, images: Sequence[CeilingImage], after: float) -> float:
        """Add images, and return the latest valid stamp [s] of these and earlier ones.

        Args:
            images: Simultaneous images.
            after: Time of the latest fix [s]; minus infinity before the first.
        """
        limit = self._limit(after)
        newest = max(image.stamp for image in images)
        if newest <= limit:
            self._row = []
            self._followed = self._followed or -np.inf < after < newest
            return limit
        # A smaller stamp after a jump shows that the jump was wrong.
        self._row = [*(stamp for stamp in self._row if stamp < newest), newest]
        if self._agreed(images, limit):
            self._row = []
            return newest
        return self._confirmed(after) if len(self._row) >= MIN_CONFIRMATIONS else limit

    def final_limit(self, after: float) -> float:
        """The latest valid stamp when no more images follow.

        If no image ever followed another closely, there was no clock that could have jumped.
        """
        enough = MIN_FINAL_CONFIRMATIONS if self._followed else 1
        return self._confirmed(after) if len(self._row) >= enough else self._limit(after)

    def _limit(self, after: float) -> float:
        return after + self._max_jump_s if np.isfinite(after) else np.inf

    def _agreed(self, images: Sequence[CeilingImage], limit: float) -> bool:
        """Whether the clocks of all cameras jumped; a single camera proves nothing."""
        jumped = {image.camera for image in images if image.stamp > limit}
        return len(self._cameras) > 1 and self._cameras <= jumped

    def _confirmed(self, after: float) -> float:
        """Accept the consecutive jumps, and adapt to their spacing."""
        newest, spacing = self._row[-1], float(np.median(np.diff([after, *self._row])))
        self._max_jump_s = max(MAX_JUMP_S, SPACING_FACTOR * spacing)
        self._row = []
        return newest


class IntelligentSpace:
    """Detects the tag in every image and fuses the poses."""

    def __init__(
        self,
        cameras: Sequence[FixedCamera],
        mount: TagMount | None = None,
        settings: SpaceSettings | None = None,
    ) -> None:
        """Create a detector for each camera.

        Args:
            cameras: Calibrated cameras with different names.
            mount: The robot's tag.
            settings: See `SpaceSettings`.

        Raises:
            InputError: There is no camera, or two have the same name.
            MissingExtraError: pupil-apriltags is not installed.
        """
        names = [camera.name for camera in cameras]
        if not names or len(set(names)) < len(names):
            raise InputError(f"cameras must have different names, not {names}")
        self.mount, self.settings = mount or TagMount(), settings or SpaceSettings()
        self._watches = {c.name: TagObserver(c, self.mount, self.settings) for c in cameras}
        self._tracker = SpaceTracker(self.settings)
        self._guard = ClockJumpFilter(self._watches)
        self._behind = 0
        self._set_back: list[str] = []
        self._pool = ThreadPoolExecutor(min(self.settings.workers, len(names)))

    @property
    def reports(self) -> tuple[str, ...]:
        """Sentences about cameras that moved since calibration, and clocks that were set back."""
        return (*self._tracker.watch.reports, *self._set_back)

    def track(self, images: Iterable[CeilingImage]) -> Iterator[SpaceFix]:
        """Compute a fix for the images of each time, in the order of arrival.

        Images whose stamps jump ahead wait for confirmation by later images. If they are not
        confirmed, their fix repeats the previous time, with the reason.

        Args:
            images: Images of all cameras, in the order of arrival.
        """
        waiting: list[Sequence[CeilingImage]] = []
        for slot in slots(images, self.settings.slot):
            until = self._guard.update(slot, self._tracker.stamp)
            waiting.append(slot)
            jumps = max(image.stamp for image in slot) > until
            if not jumps or len(waiting) >= MAX_PENDING:
                yield from (self._located(held, until) for held in waiting)
                waiting = []
        until = self._guard.final_limit(self._tracker.stamp)
        yield from (self._located(held, until) for held in waiting)

    def locate(self, images: Sequence[CeilingImage]) -> SpaceFix:
        """Localise the robot from simultaneous images.

        Args:
            images: At least one, and at most one per camera. Images of uncalibrated cameras, late
                images, and images whose stamps jump ahead are rejected with a reason. A jump of all
                cameras is accepted at once, another one the third time.

        Returns:
            The fix; if all images are late, a fix at the previous time with the reasons.

        Raises:
            InputError: There is no image.
        """
        if not images:
            raise InputError("there is no image")
        return self._located(images, self._guard.update(images, self._tracker.stamp))

    def _located(self, images: Sequence[CeilingImage], until: float) -> SpaceFix:
        """See `locate`; stamps later than `until` [s] are jumps."""
        self._reset_if_set_back(max(image.stamp for image in images))
        after = self._tracker.stamp
        sightings = list(self._pool.map(lambda image: self._look(image, after, until), images))
        fresh = [s.stamp for s in sightings if after < s.stamp <= until]
        return self._tracker.take(float(np.median(fresh)) if fresh else after, sightings)

    def _reset_if_set_back(self, newest: float) -> None:
        """Reset after the clock was set back; otherwise all further images would be late."""
        back = self._tracker.stamp - newest
        self._behind = self._behind + 1 if back > MIN_SETBACK_S else 0
        if self._behind < MIN_CONFIRMATIONS:
            return
        self._behind = 0
        self._set_back.append(f"the cameras' clock was set back by {back:.1f} s at {newest:.3f} s")
        self._tracker.reset()
        for watch in self._watches.values():
            watch.reset()

    def _look(self, image: CeilingImage, after: float, until: float) -> Sighting:
        if image.stamp > until:
            ahead = f"by {image.stamp - after:.1f} s"
            return Sighting(image.camera, image.stamp, reason="its stamp jumps ahead", detail=ahead)
        watch = self._watches.get(image.camera)
        if watch is None:
            known = ", ".join(self._watches)
            reason = f"no calibration of this camera; known: {known}"
            return Sighting(image.camera, image.stamp, reason=reason)
        return watch.look(image, after)
