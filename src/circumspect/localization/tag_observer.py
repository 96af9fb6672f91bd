"""Pose of the robot from the images of one ceiling camera."""

from __future__ import annotations

import numpy as np

from circumspect.errors import GeometryError
from circumspect.localization.ceiling_image import CeilingImage
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.space_fix import NO_TAG, Sighting
from circumspect.localization.space_settings import SpaceSettings
from circumspect.localization.tag_detector import DECIMATIONS, TagDetection, TagDetector
from circumspect.localization.tag_mount import TagMount
from circumspect.localization.tag_pose import tag_pose

MIN_SIDE_PX = 13.5
"""Tag side after decimation at which the detector finds every tag; it misses some smaller ones
(benchmarks/intelligent_space.py)."""
MAX_DECIMATION = 4.0


class TagObserver:
    """Detects the robot's tag in the images of one camera; not thread-safe."""

    def __init__(
        self, camera: FixedCamera, mount: TagMount, settings: SpaceSettings | None = None
    ) -> None:
        """Create the detector.

        Args:
            camera: The camera.
            mount: The robot's tag.
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
        """Process an image.

        Args:
            image: Image of this camera.
            after: Time of the latest fix; images that are not later are too late [s].
        """
        if (rejection := self._rejection(image, after)) is not None:
            return rejection
        self._last = image
        found = self._detector.detect(image.grey)
        own = [tag for tag in found if tag.tag_id == self.mount.tag_id]
        others = tuple(sorted({tag.tag_id for tag in found} - {self.mount.tag_id}))
        head = (image.camera, image.stamp)
        if len(own) != 1:
            twice = f"tag {self.mount.tag_id} is in the image {len(own)} times: ambiguous"
            known = f"unknown tags are: {', '.join(map(str, others))}" if others else None
            if own:
                return Sighting(*head, reason=twice, others=others)
            return Sighting(*head, reason=NO_TAG, others=others, detail=known)
        if self._is_cut(own[0]):
            return Sighting(*head, reason="the tag is at the edge of the image", others=others)
        sigmas = self.settings.corner_sigma, self.settings.common_sigma
        try:
            pose = tag_pose(self.camera, self.mount, own[0].corners_uv, *sigmas)
        except GeometryError as error:
            return Sighting(*head, reason=str(error), others=others)
        if pose.squared_residual > self.settings.max_squared_residual:
            reason = (
                f"the corners are not those of a level tag of {self.mount.size:g} m: blurred, "
                "tilted or of another size"
            )
            squared_residual = f"squared residual {pose.squared_residual:.0f}"
            return Sighting(*head, reason=reason, others=others, detail=squared_residual)
        return Sighting(*head, pose=pose, others=others)

    def reset(self) -> None:
        """Forget the previous image, because the clock was reset."""
        self._last = None

    def _rejection(self, image: CeilingImage, after: float) -> Sighting | None:
        """The rejection of an unusable image, or None."""
        head = (image.camera, image.stamp, None)
        size = (image.grey.shape[1], image.grey.shape[0])
        if size != self.camera.lens.size:
            w, h = self.camera.lens.size
            pixels = f"the image has {size[0]}x{size[1]} pixels, the calibration {w}x{h}"
            return Sighting(*head, pixels)
        last = self._last
        if last is not None and image.stamp <= last.stamp:
            stale = "stale: its stamp is not later than the last one"
            return Sighting(*head, stale, detail=f"of {last.stamp:.3f} s")
        if image.stamp <= after:
            late = "late: there is a fix for its time already"
            return Sighting(*head, late, detail=f"up to {after:.3f} s")
        if last is not None and np.array_equal(last.grey, image.grey):
            return Sighting(*head, "frozen: identical to the previous image")
        return None

    def _is_cut(self, tag: TagDetection) -> bool:
        w, h = self.camera.lens.size
        low, high = tag.corners_uv.min(axis=0), tag.corners_uv.max(axis=0)
        edge = self.settings.edge
        return bool((low < edge).any() or (high > np.array([w, h]) - 1 - edge).any())


def suitable_decimation(camera: FixedCamera, mount: TagMount) -> float:
    """The largest decimation at which the tag is still found everywhere in the image."""
    w, h = camera.lens.size
    u, v = np.meshgrid([0.1 * w, 0.5 * w, 0.9 * w], [0.1 * h, 0.5 * h, 0.9 * h])
    places = camera.on_plane(np.column_stack([u.ravel(), v.ravel()]), mount.height)
    sides = []
    for x, y in places[np.isfinite(places).all(axis=1)]:
        ground = mount.corners_xy - mount.T_base_tag.xy + [x, y]
        seen = camera.project(np.column_stack([ground, np.full(len(ground), mount.height)]))
        sides.append(float(np.linalg.norm(seen - np.roll(seen, 1, axis=0), axis=1).min()))
    known = [side for side in sides if np.isfinite(side)]
    fitting = min(min(known, default=0.0) / MIN_SIDE_PX, MAX_DECIMATION)
    return max((factor for factor in DECIMATIONS if factor <= fitting), default=1.0)
