"""One simulated scan, of whose fits is kept what they tell and by what they err."""

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
from circumspect.mapping import RegisteredPoses, TrackingSettings
from circumspect.mapping.keyframe_pairs import is_consecutive
from circumspect.mapping.keyframes import Keyframes
from circumspect.pipeline import RecognitionResult, RecognitionStep
from circumspect.registration import Scan, ScanSurface, SurfaceMap, register
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import RgbdFrame

EVERY = 8
"""Each such frame makes the map at its true pose; those between are fitted to it."""
PRIOR_SIGMAS = np.full(6, 0.01)
"""From so far off [rad, m] they are fitted."""
DIGITS = 6


@dataclass(frozen=True)
class CalibrationJob:
    """A scan to compare fits with the truth over.

    Attributes:
        scan: How it is driven.
    """

    scan: ScanJob

    @property
    def key(self) -> str:
        """Tells it from all others."""
        return self.scan.key


class Told(NamedTuple):
    """A relative pose beside the truth.

    Attributes:
        error: (6,) change [rad, m] from the true one to it.
        information: (6, 6) what was told of that.
    """

    error: NDArray[np.float64]
    information: NDArray[np.floating]

    @property
    def squared(self) -> float:
        """eᵀΩe, where Ω is right of mean 6."""
        return float(self.error @ self.information @ self.error)


def run_job(job: CalibrationJob) -> dict[str, Any]:
    """Scan, and compare; JSON types.

    Returns:
        Of each fit to a map of true poses `fits`, eᵀΩe and eᵀHe; of each keyframe that the scene
        held from the last one on `steps`, the error and the upper triangle of H; of each edge of
        the final graph `edges`, whether its ends are consecutive, the turn between them [rad],
        and eᵀΩe.
    """
    parts = prepared(job.scan)
    poses = parts.pipeline.poses
    assert isinstance(poses, RegisteredPoses)
    seen, chain = KeptScans(parts.witness, poses.settings), Chain(poses.keyframes)
    parts.pipeline.observers = (chain,)
    parts.driven_by(seen).scan.run()
    truth = partial(true_pose, parts.witness.trajectory)
    return {
        "key": job.key,
        "object": job.scan.object,
        "fits": [short([told.squared, held]) for told, held in seen.fits(truth, job.scan.seed)],
        "steps": [
            short([*told.error, *told.information[np.triu_indices(6)]])
            for told in chain.steps(truth)
        ],
        "edges": [
            short([consecutive, turn, told.squared])
            for consecutive, turn, told in chain.edges(truth)
        ],
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

    def _seen(self, frame: RgbdFrame) -> RgbdFrame:
        self._kept.append((frame.stamp, Scan.from_frame(frame, self._settings.scan)))
        return frame

    def fits(
        self, truth: Callable[[float], RigidTransform], seed: int
    ) -> Iterator[tuple[Told, float]]:
        """What registration tells and errs by, and eᵀHe; the priors are drawn with their noise.

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
            if number % EVERY == 0 or len(scan) < settings.gate.fewest_points:
                continue
            prior = composed(truth(stamp), se3.exp(rng.normal(0, PRIOR_SIGMAS)))
            found = register(scan, scene, prior, known, settings.registration)
            error = se3.log(between(truth(stamp), found.T_map_camera))
            yield Told(error, found.information), float(error @ found.hessian @ error)


class Chain:
    """Keyframes as they were when they were taken; a `PipelineObserver`."""

    def __init__(self, keyframes: Keyframes) -> None:
        self._keyframes = keyframes
        self._stamps: dict[int, float] = {}
        self._steps: list[tuple[int, RigidTransform]] = []

    def on_step(self, step: RecognitionStep) -> None:  # noqa: ARG002 - the keyframes tell it
        """Keep the keyframe that the frame became, if it did."""
        number = self._keyframes.numbers[-1] if len(self._keyframes) else None
        if number is None or number in self._stamps:
            return
        self._stamps[number] = self._keyframes[number].stamp
        if number - 1 in self._stamps:
            last, this = self._keyframes[number - 1], self._keyframes[number]
            self._steps.append((number, between(last.T_map_camera, this.T_map_camera)))

    def on_end(self, result: RecognitionResult) -> None:
        """Nothing more to keep."""

    def steps(self, truth: Callable[[float], RigidTransform]) -> Iterator[Told]:
        """Tracking from keyframe to keyframe, where the scene held all frames, and its H."""
        for number, found in self._steps:
            last, this = self._keyframes[number - 1].passage, self._keyframes[number].passage
            if last.stretch == this.stretch and this.by_scene is not None and not this.broken:
                error = se3.log(between(self._true(truth, number - 1, number), found))
                yield Told(error, this.by_scene)

    def edges(self, truth: Callable[[float], RigidTransform]) -> Iterator[tuple[bool, float, Told]]:
        """Edges of the graph: consecutive, the turn between the two [rad], and what they tell."""
        numbers, graph = sorted(self._stamps), self._keyframes.graph()
        # Edges name keyframes by their place: all must have been seen, and none given way.
        assert len(numbers) == len(graph.poses)
        for edge in graph.between_factors:
            first, second = numbers[edge.first], numbers[edge.second]
            true = self._true(truth, first, second)
            told = Told(se3.log(between(true, edge.T_first_second)), edge.information)
            yield is_consecutive(first, second), float(true.rotation.magnitude()), told

    def _true(
        self, truth: Callable[[float], RigidTransform], first: int, second: int
    ) -> RigidTransform:
        return between(truth(self._stamps[first]), truth(self._stamps[second]))
