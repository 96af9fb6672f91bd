"""Which of the places that look like a frame to believe."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3
from circumspect.geometry.composition import between, composed
from circumspect.mapping.motion import Belief
from circumspect.mapping.relocalisation import (
    SAME_PLACE,
    SIGMAS,
    RelocalisationSettings,
    within,
)
from circumspect.registration import Registration

LIKELY = 16.8
"""Squared Mahalanobis distance that is passed by chance once in a hundred frames (six degrees of
freedom)."""
EXACT = np.array([np.radians(3.0)] * 3 + [0.05] * 3)
"""How exactly a place is recognised [rad, m]."""

VAGUE = float(np.radians(30.0)), 0.5
"""Where a camera should be says little once it is known no better than so [rad, m]: places that
look alike, as the sides of a night stand, are about as far from each other."""


class Recognition:
    """Believes in a place near by at once, in one far off only on good evidence.

    Wheels seldom mislead by more than they are uncertain; what looks alike from several sides, as
    a square table does, or has little to tell, as the flat side of a sofa, does.
    """

    def __init__(self, settings: RelocalisationSettings, farthest: float) -> None:
        """Nothing is supposed yet.

        Args:
            settings: When to believe.
            farthest: Squared Mahalanobis distance from the belief up to which a place is near.
        """
        self._settings = settings
        self._farthest = farthest
        self._supposed: RigidTransform | None = None
        self._times = 0

    def forget(self) -> None:
        """A frame was where it should be, or told of nowhere."""
        self._supposed, self._times = None, 0

    def carry(self, T_before_now: RigidTransform) -> None:
        """Keep what is supposed over a frame that says nothing.

        Args:
            T_before_now: How the camera moved since the last frame.
        """
        if self._supposed is not None:
            self._supposed = composed(self._supposed, T_before_now)

    def believed(
        self,
        fits: list[Registration],
        expected: Belief,
        T_before_now: RigidTransform,
        usual_inliers: float,
        lost: bool,
        out_of_place: bool,
        ambiguous: Callable[[Registration], bool],
    ) -> Registration | None:
        """The one place where the camera can be.

        Args:
            fits: Of a frame that contradicts its pose; see `relocalise`.
            expected: Where the camera should be.
            T_before_now: How it moved since the last frame.
            usual_inliers: Of a good frame.
            lost: Several frames contradicted.
            out_of_place: The frame shows things where it was known to be empty, if the camera is
                where it should be. One that shows nothing, or what is new, is no reason to believe
                that the camera was carried off.
            ambiguous: Whether the frame fits aside of a place as well. Such a place speaks against
                being elsewhere, but not for being there.

        Returns:
            Of those with enough inliers the only one near by, at once where the camera is likely
            to be there; else, once the camera is lost and can not be where it should be, the only
            one at all. What is not believed at once is when several frames in a row told of it. A
            lost camera that may be where it should be is believed to be near by only so, and only
            if nothing else looks like its frame.
        """
        enough = self._settings.least_inliers * usual_inliers
        fits = [fit for fit in fits if fit.inliers >= enough]
        near = [fit for fit in fits if _distance(fit, expected, SIGMAS) < self._farthest]
        # A lost camera that nothing speaks against may well be where it should be, before news.
        doubtful = lost and not out_of_place
        # And one that may be anywhere is near to every place.
        vague = expected.sigmas[0] > VAGUE[0] or expected.sigmas[1] > VAGUE[1]
        at_once = not doubtful and not vague
        if len(near) == 1 and at_once and _distance(near[0], expected, EXACT) < LIKELY:
            self.forget()
            return None if ambiguous(near[0]) else near[0]
        carried_off = not near and lost and out_of_place
        possible = fits if carried_off or (near and doubtful) else near
        if len(possible) != 1 or ambiguous(possible[0]):
            self.forget()
            return None
        (only,) = possible
        return only if self._confirms(only.T_map_camera, T_before_now) else None

    def _confirms(self, T_map_camera: RigidTransform, T_before_now: RigidTransform) -> bool:
        supposed = self._supposed
        if supposed is None or not within(
            composed(supposed, T_before_now), T_map_camera, SAME_PLACE
        ):
            self._times = 0
        self._supposed = T_map_camera
        self._times += 1
        return self._times >= self._settings.confirmed


def _distance(fit: Registration, expected: Belief, sigmas: NDArray[np.float64]) -> float:
    """Squared Mahalanobis distance between a fit and where the camera should be.

    Args:
        fit: The fit.
        expected: Where the camera should be.
        sigmas: Standard deviations [rad, m] beside those of the belief.
    """
    error = se3.log(between(expected.T_map_camera, fit.T_map_camera))
    return float(error @ np.linalg.inv(expected.covariance + np.diag(sigmas**2)) @ error)
