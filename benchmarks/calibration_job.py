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
"""The map contains every N-th frame at its true pose; the others are registered to it."""
PRIOR_SIGMAS = np.full(6, 0.01)
"""Standard deviations of the priors' errors [rad, m]."""
DIGITS = 6


@dataclass(frozen=True)
class CalibrationJob:
    """A scan whose registrations and factors are compared with the truth.

    Attributes:
        scan: The scan.
    """

    scan: ScanJob

    @property
    def key(self) -> str:
        """Unique name."""
        return self.scan.key


class Measured(NamedTuple):
    """A measured pose compared with the truth.

    Attributes:
        error: (6,) change [rad, m] from the true pose to the measured one.
        information: (6, 6) information of the measurement.
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
    """Run a scan and compare its measurements with the truth.

    Returns:
        JSON types. "fits": eᵀΩe and eᵀHe of each registration to a map of true poses. "tracking":
        `Measured.row` of each factor from tracking. "pairs": angle between the views [rad] and
        eᵀΩe of each registered pair of keyframes.
    """
    parts = prepared(job.scan)
    tracker = parts.pipeline.tracker.estimator
    assert isinstance(tracker, Tracker)
    robot, log = (
        ScanRecorder(parts.ground_truth, tracker.settings),
        KeyframeLog(parts.pipeline.tracker),
    )
    parts.driven_by(robot).scan.run((log,))
    truth = partial(true_pose, parts.ground_truth.trajectory)
    return {
        "key": job.key,
        "object": job.scan.object,
        "fits": [
            short([fit.squared, by_scan]) for fit, by_scan in robot.fits(truth, job.scan.seed)
        ],
        "tracking": [measured.row for measured in log.tracking(truth)],
        "pairs": [short([angle, measured.squared]) for angle, measured in log.pairs(truth)],
    }


def short(values: Sequence[float]) -> list[float]:
    """Values rounded to `DIGITS` significant digits."""
    return [float(f"{value:.{DIGITS}g}") for value in values]


def true_pose(truth: Trajectory, stamp: float) -> RigidTransform:
    """The true `T_map_camera` nearest in time."""
    return truth.T_map_camera[int(np.argmin(np.abs(truth.stamps - stamp)))]


class ScanRecorder(WrappedRobot):
    """A robot wrapper that keeps the downsampled scan of each frame."""

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
            seed: Seed of the priors' noise.
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
    """Records the times of the keyframes; a `PipelineObserver`."""

    def __init__(self, tracker: BackgroundTracker) -> None:
        self._tracker = tracker
        self._stamps: list[float] = []

    @property
    def _keyframes(self) -> KeyframeMap:
        """The keyframes so far; waits for the background worker."""
        tracker = self._tracker.estimator
        assert isinstance(tracker, Tracker)
        return tracker.keyframes

    def on_step(self, step: RecognitionStep) -> None:
        """Record the time of the frame if it became a keyframe."""
        if len(self._keyframes) > len(self._stamps):
            self._stamps.append(step.stamp)

    def on_end(self, result: RecognitionResult) -> None:
        """Do nothing."""

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
        # Keyframes and stamps have the same numbers while no keyframe is culled.
        assert len(self._keyframes) == len(self._stamps) < KeyframeSettings().max_keyframes
        return self._keyframes.factors

    def _measured(
        self, factor: BetweenFactor, truth: Callable[[float], RigidTransform]
    ) -> Measured:
        first, second = (truth(self._stamps[number]) for number in (factor.first, factor.second))
        error = se3.log(between(between(first, second), factor.T_first_second))
        return Measured(error, factor.information)
