"""From one camera's images to its word about the robot."""

from __future__ import annotations

import numpy as np

from circumspect.errors import GeometryError
from circumspect.localization.ceiling_image import CeilingImage
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.sighting import NO_TAG, Sighting
from circumspect.localization.space_settings import SpaceSettings
from circumspect.localization.tag_detector import DECIMATIONS, TagDetection, TagDetector
from circumspect.localization.tag_mount import TagMount
from circumspect.localization.tag_pose import tag_pose

FOUND_SIDE = 13.5
"""The detector finds every tag whose side has so many pixels after decimation, and loses some of
smaller ones (benchmarks/intelligent_space.py)."""
MOST_DECIMATION = 4.0


class TagWatch:
    """Looks for the robot's tag in the images of one camera; not for several threads at a time."""

    def __init__(
        self, camera: FixedCamera, mount: TagMount, settings: SpaceSettings | None = None
    ) -> None:
        """Set up a detector of its own.

        Args:
            camera: Which.
            mount: The tag to look for.
            settings: See `SpaceSettings`.

        Raises:
            MissingExtraError: pupil-apriltags is not installed.
        """
        self.camera, self.mount = camera, mount
        self.settings = settings or SpaceSettings()
        decimate = self.settings.decimate or suitable_decimation(camera, mount)
        self._detector = TagDetector(decimate)
        self._last: CeilingImage | None = None

    def look(self, image: CeilingImage, after: float = -np.inf) -> Sighting:
        """What an image says.

        Args:
            image: Of this camera.
            after: Time of the latest fix: what is not later comes too late [s].
        """
        if (unfit := self._unfit(image, after)) is not None:
            return unfit
        self._last = image
        found = self._detector.detect(image.grey)
        own = [tag for tag in found if tag.tag_id == self.mount.tag_id]
        others = tuple(sorted({tag.tag_id for tag in found} - {self.mount.tag_id}))
        head = (image.camera, image.stamp)
        if len(own) != 1:
            twice = f"tag {self.mount.tag_id} is in the image {len(own)} times; which is it?"
            known = f"unknown tags are: {', '.join(map(str, others))}" if others else None
            if own:
                return Sighting(*head, reason=twice, others=others)
            return Sighting(*head, reason=NO_TAG, others=others, detail=known)
        if self._cut(own[0]):
            return Sighting(*head, reason="the tag is at the image's edge", others=others)
        sigmas = self.settings.corner_sigma, self.settings.common_sigma
        try:
            pose = tag_pose(self.camera, self.mount, own[0].corners_uv, *sigmas)
        except GeometryError as error:
            return Sighting(*head, reason=str(error), others=others)
        if pose.misfit > self.settings.misfit_gate:
            reason = (
                f"the corners are not those of a level tag of {self.mount.size:g} m: blurred, "
                "tilted or of another size"
            )
            misfit = f"misfit {pose.misfit:.0f}"
            return Sighting(*head, reason=reason, others=others, detail=misfit)
        return Sighting(*head, pose=pose, others=others)

    def begin_anew(self) -> None:
        """Forget the image before: its stamp is of another time."""
        self._last = None

    def _unfit(self, image: CeilingImage, after: float) -> Sighting | None:
        """Why an image can not be used at all."""
        head = (image.camera, image.stamp, None)
        size = (image.grey.shape[1], image.grey.shape[0])
        if size != self.camera.lens.size:
            w, h = self.camera.lens.size
            pixels = f"the image has {size[0]}x{size[1]} pixels, calibrated were {w}x{h}"
            return Sighting(*head, pixels)
        last = self._last
        if last is not None and image.stamp <= last.stamp:
            stale = "stale: its stamp is not later than the last one"
            return Sighting(*head, stale, detail=f"of {last.stamp:.3f} s")
        if image.stamp <= after:
            late = "late: its time was answered already"
            return Sighting(*head, late, detail=f"up to {after:.3f} s")
        if last is not None and np.array_equal(last.grey, image.grey):
            return Sighting(*head, "frozen: pixel by pixel the image before")
        return None

    def _cut(self, tag: TagDetection) -> bool:
        w, h = self.camera.lens.size
        low, high = tag.corners_uv.min(axis=0), tag.corners_uv.max(axis=0)
        edge = self.settings.edge
        return bool((low < edge).any() or (high > np.array([w, h]) - 1 - edge).any())


def suitable_decimation(camera: FixedCamera, mount: TagMount) -> float:
    """How much smaller an image can be made so that the tag is still found all over it."""
    w, h = camera.lens.size
    u, v = np.meshgrid([0.1 * w, 0.5 * w, 0.9 * w], [0.1 * h, 0.5 * h, 0.9 * h])
    places = camera.on_plane(np.column_stack([u.ravel(), v.ravel()]), mount.height)
    sides = []
    for x, y in places[np.isfinite(places).all(axis=1)]:
        ground = mount.corners_xy - mount.T_base_tag.xy + [x, y]
        seen = camera.project(np.column_stack([ground, np.full(len(ground), mount.height)]))
        sides.append(float(np.linalg.norm(seen - np.roll(seen, 1, axis=0), axis=1).min()))
    known = [side for side in sides if np.isfinite(side)]
    fitting = min(min(known, default=0.0) / FOUND_SIDE, MOST_DECIMATION)
    return max((factor for factor in DECIMATIONS if factor <= fitting), default=1.0)
