"""One simulated scan: errors of registrations and of factors, with their information."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from benchmarks.scan_job import ScanJob, prepared
from circumspect.geometry import Trajectory, se3
from circumspect.geometry.composition import between, composed
from circumspect.pose_graph import BetweenFactor, KeyframeMap, KeyframeSettings
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.recognition.background_worker import BackgroundTracker
from circumspect.registration import Scan, ScanSurface, SurfaceMap, register
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import RgbdFrame
from circumspect.tracking import Tracker, TrackingSettings

EVERY = 8
"""Each such frame makes the map at its true pose; those between are fitted to it."""
PRIOR_SIGMAS = np.full(6, 0.01)
"""From so far off [rad, m] they are fitted."""
DIGITS = 6


@dataclass(frozen=True)
class CalibrationJob:
    """A scan whose registrations and factors are compared with the truth.

    Attributes:
        scan: How it is driven.
    """

    scan: ScanJob

    @property
    def key(self) -> str:
        """Identifies it among all others."""
        return self.scan.key


class Measured(NamedTuple):
    """A measured pose beside the truth.

    Attributes:
        error: (6,) change [rad, m] from the true pose to the measured one.
        information: (6, 6) of the measurement.
    """

    error: NDArray[np.float64]
    information: NDArray[np.floating]

    @property
    def squared(self) -> float:
        """eᵀΩe; its mean is 6 if Ω is consistent with the errors."""
        return float(self.error @ self.information @ self.error)

    @property
    def row(self) -> list[float]:
        """27 numbers: the error, and the upper triangle of the information."""
        return short([*self.error, *self.information[np.triu_indices(6)]])


def run_job(job: CalibrationJob) -> dict[str, Any]:
    """Scan, and compare; JSON types.

    Returns:
        For each registration to a map of true poses `fits`, eᵀΩe and eᵀHe; for each factor from
        tracking `tracking`, see `Measured.row`; for each pair of registered keyframes `pairs`, the
        angle between the views [rad] and eᵀΩe.
    """
    parts = prepared(job.scan)
    tracker = parts.pipeline.tracker.estimator
    assert isinstance(tracker, Tracker)
    seen, log = KeptScans(parts.ground_truth, tracker.settings), KeyframeLog(parts.pipeline.tracker)
    parts.driven_by(seen).scan.run((log,))
    truth = partial(true_pose, parts.ground_truth.trajectory)
    return {
        "key": job.key,
        "object": job.scan.object,
        "fits": [short([fit.squared, held]) for fit, held in seen.fits(truth, job.scan.seed)],
        "tracking": [measured.row for measured in log.tracking(truth)],
        "pairs": [short([angle, measured.squared]) for angle, measured in log.pairs(truth)],
    }


def short(values: Sequence[float]) -> list[float]:
    """As many digits as mean something."""
    return [float(f"{value:.{DIGITS}g}") for value in values]


def true_pose(truth: Trajectory, stamp: float) -> RigidTransform:
    """`T_map_camera` as it was."""
    return truth.T_map_camera[int(np.argmin(np.abs(truth.stamps - stamp)))]


class KeptScans(WrappedRobot):
    """A robot whose frames are kept, thinned, to be fitted to a map of true poses."""

    def __init__(self, robot: MobileRobot, settings: TrackingSettings) -> None:
        super().__init__(robot)
        self._settings = settings
        self._kept: list[tuple[float, Scan]] = []

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        self._kept.append((frame.stamp, Scan.from_frame(frame, self._settings.scan)))
        return frame

    def fits(
        self, truth: Callable[[float], RigidTransform], seed: int
    ) -> Iterator[tuple[Measured, float]]:
        """Errors of registrations with their information, and eᵀHe; priors are drawn with noise.

        Args:
            truth: The true pose at a stamp.
            seed: Of the priors' noise.
        """
        rng, settings = np.random.default_rng(seed), self._settings
        surfaces = [
            (ScanSurface.from_scan(scan).with_vertical_floor_normals(truth(stamp)), truth(stamp))
            for stamp, scan in self._kept[::EVERY]
        ]
        scene = SurfaceMap(settings.scan.voxel).with_surfaces(surfaces)
        known = np.diag(PRIOR_SIGMAS**-2.0)
        for number, (stamp, scan) in enumerate(self._kept):
            if number % EVERY == 0 or len(scan) < settings.min_points:
                continue
            prior = composed(truth(stamp), se3.exp(rng.normal(0, PRIOR_SIGMAS)))
            found = register(scan, scene, prior, known, settings.registration)
            error = se3.log(between(truth(stamp), found.T_map_camera))
            yield Measured(error, found.information), float(error @ found.hessian @ error)


class KeyframeLog:
    """Times of the keyframes; a `PipelineObserver`."""

    def __init__(self, tracker: BackgroundTracker) -> None:
        self._tracker = tracker
        self._stamps: list[float] = []

    @property
    def _keyframes(self) -> KeyframeMap:
        """Those so far, once the background work is done."""
        tracker = self._tracker.estimator
        assert isinstance(tracker, Tracker)
        return tracker.keyframes

    def on_step(self, step: RecognitionStep) -> None:
        """Keep the time of the keyframe that the frame became, if it did."""
        if len(self._keyframes) > len(self._stamps):
            self._stamps.append(step.stamp)

    def on_end(self, result: RecognitionResult) -> None:
        """Nothing more to keep."""

    def tracking(self, truth: Callable[[float], RigidTransform]) -> Iterator[Measured]:
        """Factors between keyframes and their reference keyframes."""
        for factor in self._factors():
            if not factor.robust:
                yield self._measured(factor, truth)

    def pairs(self, truth: Callable[[float], RigidTransform]) -> Iterator[tuple[float, Measured]]:
        """Factors of keyframes that were registered to each other, with the view angle [rad]."""
        for factor in self._factors():
            if factor.robust:
                angle = float(factor.T_first_second.rotation.magnitude())
                yield angle, self._measured(factor, truth)

    def _factors(self) -> tuple[BetweenFactor, ...]:
        # Numbers are those of the stamps as long as no keyframe was culled.
        assert len(self._keyframes) == len(self._stamps) < KeyframeSettings().max_keyframes
        return self._keyframes.factors

    def _measured(
        self, factor: BetweenFactor, truth: Callable[[float], RigidTransform]
    ) -> Measured:
        first, second = (truth(self._stamps[number]) for number in (factor.first, factor.second))
        error = se3.log(between(between(first, second), factor.T_first_second))
        return Measured(error, factor.information)
