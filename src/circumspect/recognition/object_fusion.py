"""Fusion of the object model of a run, with corrections of earlier poses."""

from __future__ import annotations

from functools import partial
from typing import TypeAlias

from scipy.spatial.transform import RigidTransform

from circumspect.recognition.background_worker import BackgroundWorker
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
    """Fuses frames into a model, and rebuilds the model when poses are corrected.

    Submaps are updated and fused in the background. For each frame call `follow`, then `fuse`, then
    join the background worker before the next frame.

    Attributes:
        model: The current model.
    """

    def __init__(
        self, settings: ModelSettings, tracker: PoseEstimator, background: BackgroundWorker
    ) -> None:
        """Start with an empty model.

        Args:
            settings: Settings of fusion.
            tracker: Provides the poses of keyframes.
            background: Updates and fuses the submaps.
        """
        self.model = ObjectModel(settings)
        self._tracker = tracker
        self._background = background
        self._submaps = SubmapCollection()
        self._views = ViewDensity()
        self._submap_fusion: SubmapFusion | None = None
        self._corrections = tracker.corrections
        self._reference: ReferenceKeyframe | None = None

    def follow(self, pose: PoseEstimate) -> bool:
        """Apply the corrections of earlier poses that came with a frame.

        A complete fusion of submaps replaces the model. New corrections start another fusion,
        which continues in the background.

        Args:
            pose: The pose of the frame.

        Returns:
            Whether the model was replaced.
        """
        is_replaced = self._swap_model()
        # A fusion is completed first, so that frequent corrections cannot postpone it for ever.
        if self._submap_fusion is None:
            self._start_submap_fusion()
        number = pose.reference
        self._reference = None if number is None else (number, self._tracker.keyframe_pose(number))
        if self._submap_fusion is not None:
            self._background.submit(partial(self._submap_fusion.fuse_pending, VOXELS_A_FRAME))
        return is_replaced

    def fuse(self, surface: FrameSurface, T_map_camera: RigidTransform) -> bool:
        """Add a frame to the model and to the submap of its reference keyframe.

        Args:
            surface: The object's surface in the frame, map frame.
            T_map_camera: Pose of the camera.

        Returns:
            Whether the model changed. It does not if the surface is empty, or if enough frames
            were taken from the same viewpoint.
        """
        contribution = self.model.contribution(surface)
        if contribution is None or not self._views.accept(T_map_camera):
            return False
        if self._reference is not None:
            self._background.submit(partial(self._add_to_submap, *self._reference, contribution))
        if self._submap_fusion is not None:
            self._background.submit(partial(self._submap_fusion.add_contribution, contribution))
        self.model = self.model.with_contribution(contribution)
        return True

    def finalise(self) -> bool:
        """Fuse all submaps at the latest poses; returns whether the model was replaced."""
        self._background.wait()
        self._start_submap_fusion()  # discards one that is not complete
        if self._submap_fusion is not None:
            self._submap_fusion.fuse_pending()
        return self._swap_model()

    def _start_submap_fusion(self) -> None:
        """Start a fusion of the submaps if poses were corrected since the last start."""
        if self._tracker.corrections == self._corrections:
            return
        self._corrections = self._tracker.corrections
        settings, voxel = self.model.settings, self.model.voxel
        self._submap_fusion = SubmapFusion(
            self._submaps, settings, voxel, self._tracker.keyframe_pose
        )

    def _swap_model(self) -> bool:
        """Replace the model if a fusion of submaps is complete; returns whether it was."""
        if self._submap_fusion is None or not self._submap_fusion.is_complete:
            return False
        self.model, self._submap_fusion = self._submap_fusion.model, None
        return True

    def _add_to_submap(
        self, number: int, T_map_keyframe: RigidTransform, contribution: FrameContribution
    ) -> None:
        self._submaps = self._submaps.with_contribution(number, T_map_keyframe, contribution)
