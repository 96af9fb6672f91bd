"""Parts of the tracker that `benchmarks.ablation` switches off, and a neutral version of each."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.rule_patches import Patch, Rule
from circumspect.motion import MotionModel, PoseWithCovariance, RelativeMotion, motion_model
from circumspect.pose_graph import KeyframeMap
from circumspect.registration import Registration, Scan
from circumspect.registration.point_to_plane import PointToPlaneProblem
from circumspect.sensing import DepthNoise
from circumspect.tracking import (
    fixed_lag_smoother,
    hypothesis,
    hypothesis_evaluation,
    scan_likelihood,
    smoother_window,
    start_poses,
    tracker,
)
from circumspect.tracking.hypothesis_evaluation import FrameInput, HypothesisEvaluation
from circumspect.tracking.scan_likelihood import ScanLikelihood

FROM_FRAME, SHOWS_NEW_VIEW = Scan.from_frame, KeyframeMap.shows_new_view
CONTINUED = HypothesisEvaluation.continued
HUGE = 1e6
"""Replaces a bound to switch it off."""


def _nothing(*_: object, **__: object) -> None:
    """Replaces a method that may return None."""


def _no_poses(*_: object, **__: object) -> list[object]:
    return []


def _zero(*_: object, **__: object) -> float:
    return 0.0


def _itself(one: Any, *_: object) -> Any:
    """The first argument."""
    return one


def _has_inliers(found: Registration) -> bool:
    return found.inliers >= hypothesis_evaluation.MIN_POINTS


def _no_error(_: DepthNoise, depth: NDArray[np.floating]) -> NDArray[np.float64]:
    return np.zeros(np.shape(depth))


def _without_tilts(*args: Any, **kwargs: Any) -> Scan:
    scan = FROM_FRAME(*args, **kwargs)
    return replace(scan, tilts=0 * scan.tilts)


def _not_free(_: KeyframeMap, points_xyz: NDArray[np.floating], *__: object) -> Any:
    return np.zeros(len(points_xyz), bool)


def _by_baseline(keyframes: KeyframeMap, T: Any, reference: int, _: float) -> bool:
    return SHOWS_NEW_VIEW(keyframes, T, reference, 1.0)


def _by_standing_still(
    model: MotionModel, _: Any, __: float, time: float, unmeasured: float, *___: float
) -> RelativeMotion:
    return model.by_standing_still(time, unmeasured)


def _as_reported(_: MotionModel, odometry: RelativeMotion, *__: object) -> RelativeMotion:
    return odometry


def _unlevelled(_: HypothesisEvaluation, pose: PoseWithCovariance, __: FrameInput) -> Any:
    return pose


def _growth(speed: float, _: float, since: float, until: float) -> float:
    """Growth of a velocity error without bounded accelerations."""
    return speed**2 * (until**2 - since**2)


RULES = (
    Rule("systematic errors", "depth errors are white",
         (Patch(DepthNoise, "systematic_sigma", _no_error, True),)),
    Rule("systematic slopes", "slopes of surfaces have white errors only",
         (Patch(Scan, "from_frame", _without_tilts),)),
    Rule("spurious information", "all information of the normals counts",
         (Patch(PointToPlaneProblem, "without_spurious_information", _itself),)),
    Rule("convergence", "registrations count before they have converged",
         (Patch(hypothesis_evaluation, "_is_measurement", _has_inliers, True),)),
    Rule("levelness", "the floor under the robot may be uneven",
         (Patch(HypothesisEvaluation, "_levelled", _unlevelled),
          Patch(HypothesisEvaluation, "_level_factor", _nothing))),
    Rule("odometry scale", "wheels do not slip",
         (Patch(hypothesis_evaluation, "SCALE_SIGMA", 1e-6),
          Patch(tracker, "SCALE_SIGMA", 1e-6),
          Patch(smoother_window, "SCALE_DRIFT", 0.0))),
    Rule("robust kernel", "the smoother's factors have no outliers",
         (Patch(smoother_window, "CAUCHY_SCALE", HUGE),)),
    Rule("lag", "the smoother is a filter: its window has one pose",
         (Patch(fixed_lag_smoother, "LAG", 1),)),
    Rule("constant velocity", "a camera without odometry is expected to stand still",
         (Patch(MotionModel, "by_constant_velocity", _by_standing_still),)),
    Rule("accelerations", "velocities change without bound between frames",
         (Patch(motion_model, "_growth", _growth),)),
    Rule("stamp errors", "all stamps are exact",
         (Patch(FrameInput, "time_sigma", 0.0),)),
    Rule("several starts", "registrations start at the predicted pose alone",
         (Patch(start_poses, "MAX_STARTS_PER_SIDE", 0),)),
    Rule("other motions", "the first motion is used even if the scan contradicts it",
         (Patch(hypothesis_evaluation, "_is_doubtful", lambda _: False, True),)),
    Rule("slipping wheels", "a robot is not expected to stand while its wheels turn",
         (Patch(MotionModel, "by_slipping_wheels", _as_reported),)),
    Rule("several hypotheses", "only the likeliest one is kept",
         (Patch(hypothesis, "MAX_HYPOTHESES", 1),)),
    Rule("relocaliser", "a lost camera is not relocalised",
         (Patch(tracker.Tracker, "_relocalised", _no_poses),)),
    Rule("vague poses", "relocalisation starts only if a frame contradicts the pose",
         (Patch(tracker, "is_vague", lambda _: False, True),)),
    Rule("overlap of lost cameras", "a scan of unexplored space may relocalise a lost camera",
         (Patch(ScanLikelihood, "recognises", property(lambda found: found.confirms), True),)),
    Rule("free space", "scan points in free space do not count",
         (Patch(KeyframeMap, "free_space_contains", _not_free, True),)),
    Rule("seen-through surface", "map points that a frame sees through do not count",
         (Patch(scan_likelihood, "violated_count", _zero, True),)),
    Rule("floor", "points on the floor support a pose",
         (Patch(scan_likelihood, "MAX_FLOOR_HEIGHT_M", 0.0),)),
    Rule("innovation", "the likelihood is that of the scan alone",
         (Patch(Registration, "squared_innovation", _zero, True),)),
    Rule("Occam factor", "uncertain motions explain a frame as well as certain ones",
         (Patch(Registration, "log_occam_factor", _zero, True),)),
    Rule("errors of the map", "the smallest difference between similar places counts",
         (Patch(hypothesis, "MAP_ERROR_SHARE", 0.0),)),
    Rule("unknown space", "scan points in unexplored space support no pose",
         (Patch(ScanLikelihood, "support_of_unknown", _zero, True),)),
    Rule("frame limit", "one frame may decide between hypotheses",
         (Patch(hypothesis, "MAX_FRAME_RATIO", HUGE),)),
    Rule("overlap", "keyframes are added by distance and rotation only",
         (Patch(KeyframeMap, "shows_new_view", _by_baseline, True),)),
    Rule("keyframe pairs", "keyframes are not registered to each other: no loops are closed",
         (Patch(KeyframeMap, "_register", _nothing),)),
)  # fmt: skip
"""The parts that determine whether a pose is correct, and its uncertainty."""
