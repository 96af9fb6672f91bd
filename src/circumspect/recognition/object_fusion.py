"""The object model of a run, which follows corrections of earlier poses."""

from __future__ import annotations

from functools import partial
from typing import TypeAlias

from scipy.spatial.transform import RigidTransform

from circumspect.recognition.background_worker import Aside
from circumspect.reconstruction import (
    FrameContribution,
    FrameSurface,
    ModelSettings,
    ObjectModel,
    SubmapCollection,
    SubmapFusion,
    ViewDensity,
)
from circumspect.tracking import PoseEstimate, PoseEstimator

VOXELS_A_FRAME = 25_000
"""Voxels of submaps that are fused per frame after a correction."""

ReferenceKeyframe: TypeAlias = tuple[int, RigidTransform]
"""Number of a keyframe, and its `T_map_camera`."""


class ObjectFusion:
    """Fuses frames into a model, and fuses the model again when poses are corrected.

    Work that no answer depends on runs on an `Aside`. The methods must not be called until that is
    joined.

    Attributes:
        model: The current model.
    """

    def __init__(self, settings: ModelSettings, poses: PoseEstimator) -> None:
        """Start with an empty model.

        Args:
            settings: How frames are fused.
            poses: Returns the poses of keyframes.
        """
        self.model = ObjectModel(settings)
        self._poses = poses
        self._submaps = SubmapCollection()
        self._views = ViewDensity()
        self._submap_fusion: SubmapFusion | None = None
        self._corrections = poses.corrections

    def reference(self, pose: PoseEstimate) -> ReferenceKeyframe | None:
        """The reference keyframe of a frame with its current pose, if there is one."""
        number = pose.reference
        return None if number is None else (number, self._poses.keyframe_pose(number))

    def fuse(
        self,
        surface: FrameSurface,
        T_map_camera: RigidTransform,
        reference: ReferenceKeyframe | None,
        aside: Aside,
    ) -> bool:
        """Add a frame to the model and to the submap of its reference keyframe.

        Args:
            surface: The object's surface in the frame, map frame.
            T_map_camera: Pose of the camera.
            reference: The frame's reference keyframe, if there is one.
            aside: Runs the update of the submap.

        Returns:
            True if the model changed. It does not if the surface is empty, or if enough frames
            were taken from the same viewpoint.
        """
        contribution = self.model.contribution(surface)
        if contribution is None or not self._views.accept(T_map_camera):
            return False
        if reference is not None:
            aside.begin(partial(self._add_to_submap, *reference, contribution))
        if self._submap_fusion is not None:
            aside.begin(partial(self._submap_fusion.add_contribution, contribution))
        self.model = self.model.with_contribution(contribution)
        return True

    def follow_corrections(self, anyway: bool = False) -> None:
        """Start to fuse the submaps again if poses were corrected since the last start.

        Args:
            anyway: Discard a fusion that is not complete. By default it is completed first, so that
                frequent corrections cannot postpone a new model for ever.
        """
        is_busy = self._submap_fusion is not None
        if self._poses.corrections == self._corrections or (is_busy and not anyway):
            return
        self._corrections = self._poses.corrections
        settings, voxel = self.model.settings, self.model.voxel
        self._submap_fusion = SubmapFusion(
            self._submaps, settings, voxel, self._poses.keyframe_pose
        )

    def fuse_pending(self, aside: Aside) -> None:
        """Fuse some of the pending submaps, if there are any."""
        if self._submap_fusion is not None:
            aside.begin(partial(self._submap_fusion.fuse_pending, VOXELS_A_FRAME))

    def finish(self) -> None:
        """Fuse all pending submaps."""
        if self._submap_fusion is not None:
            self._submap_fusion.fuse_pending()

    def swap_model(self) -> bool:
        """Replace the model if a fusion of submaps is complete; returns whether it was."""
        if self._submap_fusion is None or not self._submap_fusion.is_complete:
            return False
        self.model, self._submap_fusion = self._submap_fusion.model, None
        return True

    def _add_to_submap(
        self, number: int, T_map_keyframe: RigidTransform, contribution: FrameContribution
    ) -> None:
        self._submaps = self._submaps.with_contribution(number, T_map_keyframe, contribution)
