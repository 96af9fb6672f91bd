"""All submaps of an object, from which `SubmapFusion` fuses the model again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.reconstruction.frame_contribution import FrameContribution
from circumspect.reconstruction.submap import Submap

MAX_SUBMAPS = 300
"""Submaps kept; beyond, the one with the fewest frames is removed."""
MAX_SUBMAP_FRAMES = 40
"""Frames per submap. The noise of further ones would keep adding voxels."""
UNCORRECTED_TOLERANCE = 1e-9
"""A keyframe pose is uncorrected if no matrix entry differs by this much."""


@dataclass(frozen=True, eq=False)
class SubmapCollection:
    """Submaps by the number of their keyframe; `with_contribution` returns a new collection.

    Attributes:
        submaps: Number of the keyframe to its submap.
        latest: Keyframe of the last contribution; only its submap has pending sums.
    """

    submaps: Mapping[int, Submap] = field(default_factory=lambda: MappingProxyType({}))
    latest: int | None = None

    def with_contribution(
        self, keyframe: int, T_map_keyframe: RigidTransform, contribution: FrameContribution
    ) -> SubmapCollection:
        """The collection with the contribution of one more frame.

        Args:
            keyframe: Number of the frame's reference keyframe.
            T_map_keyframe: Current pose of that keyframe.
            contribution: The contribution, map frame.

        Returns:
            A new collection; this one where the keyframe's submap has `MAX_SUBMAP_FRAMES` frames.
        """
        old = self.submaps.get(keyframe)
        if old is None:
            old = Submap.empty(T_map_keyframe.inv(), contribution.surface.origin_xyz)
        if len(old.views_xyz) >= MAX_SUBMAP_FRAMES:
            return self
        # Map and submap frame differ after a correction of the keyframe.
        T_map_submap = composed(T_map_keyframe, old.T_keyframe_submap)
        deviation = np.abs(T_map_submap.as_matrix() - np.eye(4)).max()
        uncorrected = deviation < UNCORRECTED_TOLERANCE
        local = contribution if uncorrected else contribution.transformed(T_map_submap.inv())
        submaps = {**self.submaps, keyframe: old.with_contribution(local)}
        if self.latest is not None and self.latest != keyframe:
            submaps[self.latest] = submaps[self.latest].compacted()
        if len(submaps) > MAX_SUBMAPS:
            others = [number for number in submaps if number != keyframe]
            del submaps[min(others, key=lambda number: len(submaps[number].views_xyz))]
        return SubmapCollection(MappingProxyType(submaps), keyframe)
