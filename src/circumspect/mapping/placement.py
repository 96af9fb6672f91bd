"""Placing a frame from one prediction, and judging what comes out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.mapping.ambiguity import is_ambiguous
from circumspect.mapping.attempt import Attempt
from circumspect.mapping.gate import Verdict
from circumspect.mapping.keyframes import Keyframes
from circumspect.mapping.leap import is_hasty
from circumspect.mapping.motion import Belief
from circumspect.mapping.news import rest_is_news
from circumspect.mapping.tracking_settings import TrackingSettings
from circumspect.mapping.usual_frames import UsualFrames
from circumspect.registration import (
    Registration,
    Scan,
    SurfaceMap,
    linearised,
    register,
    violated_points,
    violation_ratio,
)
from circumspect.sensing import RgbdFrame

KNOWN = 0.5
"""A pose whose standard deviation is less than this share of the reach of correspondences finds
the right ones; a turn counts by what it moves at 1 m."""
VAGUE, REGAINED = 5.0, 0.7
"""After a pose that was known to so many reaches only the next one is believed where this share of
the frame lies on what is known."""
GLANCE = 3
"""Every third point shows whether a further prediction is worth a closer look."""


class Placement:
    """Fits frames to the scene and asks all that may speak against a fit.

    Attributes:
        scene: What frames are fitted to.
        usual: What frames that fit are like.
    """

    def __init__(self, settings: TrackingSettings, keyframes: Keyframes) -> None:
        """Begin with an empty scene.

        Args:
            settings: How frames are followed.
            keyframes: That the scene is made of, and what they looked through.
        """
        self._settings, self._keyframes = settings, keyframes
        self.scene = SurfaceMap(settings.scan.voxel)
        self.usual = UsualFrames()
        self._phantoms = np.empty(0, np.int64)

    def seen_through(self, frame: RgbdFrame, T_map_camera: RigidTransform) -> float:
        """Share of the scene in view that a frame looks through; see `violation_ratio`."""
        return violation_ratio(frame, self.scene, T_map_camera, self._phantoms)

    def hear(self, frame: RgbdFrame, T_map_camera: RigidTransform) -> None:
        """What a keyframe looks through speaks against no frame from now on."""
        phantoms = np.union1d(self._phantoms, violated_points(frame, self.scene, T_map_camera))
        self._phantoms = np.intersect1d(phantoms, self.scene.sums.keys, assume_unique=True)

    def attempt(
        self,
        frame: RgbdFrame,
        scan: Scan,
        before: Belief,
        believed: Belief,
        source: str,
        below: float = np.inf,
    ) -> Attempt:
        """Fit a frame from one prediction, and judge.

        Args:
            frame: The frame.
            scan: Its points.
            before: The pose at the last frame.
            believed: The prediction.
            source: What it is of.
            below: Of no use unless it comes nearer to the map than this [m], on the mean.

        Returns:
            Prediction and fit fused by their information; the prediction itself where the fit
            says nothing, contradicts, or is of no use.
        """
        s = self._settings
        information = np.linalg.inv(believed.covariance)
        if below < np.inf and self._at_a_glance(scan, believed, information) >= below:
            return Attempt(believed, Verdict("fits no better", mute=True), source)
        found = register(scan, self.scene, believed.T_map_camera, information, s.registration)
        through = self.seen_through(frame, found.T_map_camera)
        least = self._least_overlap(scan, found, before, believed)
        verdict = s.gate.verdict(found, information, through, least)
        if verdict.is_open and is_hasty(
            scan, self.scene, found, believed, self.usual.most_distance, s.registration
        ):
            hasty = Verdict("far from where it was expected", mute=True)
            return Attempt(believed, hasty, source, refused=found)
        if verdict.contradicts or verdict.mute:
            return Attempt(believed, verdict, source, found)
        if is_ambiguous(scan, self.scene, found, believed, s.registration):
            ambiguous = Verdict("fits elsewhere as well", mute=True)
            return Attempt(believed, ambiguous, source, refused=found)
        # By their information; directions that the scene does not hold stay as predicted.
        fused = Belief(found.T_map_camera, np.linalg.inv(found.information))
        return Attempt(fused, verdict, source, found, prediction=believed)

    def _at_a_glance(
        self, scan: Scan, believed: Belief, information: NDArray[np.floating]
    ) -> float:
        """How near a frame comes to the map [m], on the mean, where a few of its points fit."""
        some, settings = scan.subsampled(GLANCE), self._settings.registration
        found = register(some, self.scene, believed.T_map_camera, information / GLANCE, settings)
        T_map_camera = found.T_map_camera.as_matrix()
        return linearised(scan, self.scene, T_map_camera, settings.max_distance).distance

    def _least_overlap(
        self, scan: Scan, found: Registration, before: Belief, expected: Belief
    ) -> float:
        """Share of a frame that must lie on what is known; none where the rest is news."""
        s, reach = self._settings, self._settings.registration.max_distance
        usual = max(s.gate.least_overlap, s.keeps_overlap * self.usual.overlap)
        if max(before.sigmas) > VAGUE * reach:
            return max(usual, REGAINED)
        # What is new fits anywhere; it says something only where the pose is known already.
        if found.overlap >= usual or max(expected.sigmas) > KNOWN * reach:
            return usual
        return 0.0 if rest_is_news(scan, found, self.scene, self._keyframes, reach) else usual
