"""The object's model while frames come, and once earlier poses were corrected."""

from __future__ import annotations

from functools import partial
from typing import TypeAlias

from scipy.spatial.transform import RigidTransform

from circumspect.mapping import (
    FrameShare,
    FrameSurface,
    ModelSettings,
    ObjectModel,
    ObjectViews,
    PoseEstimate,
    PoseEstimator,
    Rebuild,
)
from circumspect.mapping.view_crowd import ViewCrowd
from circumspect.pipeline.aside import Aside

VOXELS_A_FRAME = 25_000
"""So many of the patches' are put together anew after a correction; the rest waits."""

Anchor: TypeAlias = tuple[int, RigidTransform]
"""Number of a keyframe, and its `T_map_camera`."""


class ObjectFusion:
    """Fuses frames into a model, which follows the poses that they hang on.

    What no answer waits for is begun aside; nothing here is asked before that is joined.

    Attributes:
        model: The object so far.
    """

    def __init__(self, settings: ModelSettings, poses: PoseEstimator) -> None:
        """Nothing is known yet.

        Args:
            settings: How frames are fused.
            poses: Says where keyframes are.
        """
        self.model = ObjectModel(settings)
        self._poses = poses
        self._views = ObjectViews()
        self._crowd = ViewCrowd()
        self._rebuild: Rebuild | None = None
        self._corrections = poses.corrections

    def anchor(self, pose: PoseEstimate) -> Anchor | None:
        """The keyframe that a frame hangs on, and where that is believed to be."""
        return None if pose.anchor is None else (pose.anchor, self._poses.anchor_pose(pose.anchor))

    def fuse(
        self,
        surface: FrameSurface,
        T_map_camera: RigidTransform,
        anchor: Anchor | None,
        aside: Aside,
    ) -> bool:
        """Add what a frame shows.

        Args:
            surface: The object's, map frame.
            T_map_camera: Where the frame was taken from.
            anchor: What it hangs on, if anything.
            aside: Keeps it for a model that is put together anew.

        Returns:
            Whether the model is another one now: not if the frame shows nothing of the object,
            or was taken from where enough others were.
        """
        share = self.model.share(surface)
        if share is None or not self._crowd.admits(T_map_camera):
            return False
        if anchor is not None:
            aside.begin(partial(self._keep, *anchor, share))
        if self._rebuild is not None:
            aside.begin(partial(self._rebuild.with_share, share))
        self.model = self.model.with_share(share)
        return True

    def follow_corrections(self, anyway: bool = False) -> None:
        """Begin to put the model together anew where poses told earlier were corrected since.

        Args:
            anyway: Even if what was begun before is not finished. It is otherwise, lest frequent
                corrections leave the model as it was for ever.
        """
        if self._poses.corrections == self._corrections or not (anyway or self._rebuild is None):
            return
        self._corrections = self._poses.corrections
        settings, voxel = self.model.settings, self.model.voxel
        self._rebuild = Rebuild(self._views, settings, voxel, self._poses.anchor_pose)

    def go_on(self, aside: Aside) -> None:
        """Put a part of it together anew, if that is being done."""
        if self._rebuild is not None:
            aside.begin(partial(self._rebuild.go_on, VOXELS_A_FRAME))

    def finish(self) -> None:
        """Put together the rest."""
        if self._rebuild is not None:
            self._rebuild.go_on()

    def take_over(self) -> bool:
        """Whether there is a model that was put together anew; it takes the old one's place."""
        if self._rebuild is None or not self._rebuild.is_whole:
            return False
        self.model, self._rebuild = self._rebuild.model, None
        return True

    def _keep(self, anchor: int, T_map_anchor: RigidTransform, share: FrameShare) -> None:
        self._views = self._views.with_share(anchor, T_map_anchor, share)
