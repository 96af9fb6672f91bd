"""The rules of the tracker, and a neutral version of each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from benchmarks.rule_patches import Patch, Rule
from circumspect.mapping import (
    keyframe_pairs,
    keyframes,
    placement,
    predictions,
    wheel_grip,
    wheel_motion,
    wheels,
)
from circumspect.mapping import registered_poses as tracker
from circumspect.mapping.attempt import Attempt
from circumspect.mapping.first_pose import FirstPose
from circumspect.mapping.gate import GateSettings, Verdict
from circumspect.mapping.heirs import Heirs
from circumspect.mapping.hindsight import Hindsight
from circumspect.mapping.keyframe import Keyframe
from circumspect.mapping.keyframes import Keyframes
from circumspect.mapping.motion import Belief
from circumspect.mapping.placement import Placement
from circumspect.mapping.probation import Probation
from circumspect.mapping.recent_motion import RecentMotion
from circumspect.mapping.recognition import Recognition
from circumspect.mapping.usual_frames import UsualFrames
from circumspect.registration import Registration, ScanSurface

VERDICT = GateSettings.verdict
IS_CONTRADICTED, HEARD = wheel_grip.WheelGrip.is_contradicted, wheels.Wheels.heard
FIRST_POSE, LEAST_OVERLAP = FirstPose.at, Placement._least_overlap
RECOGNISED, RELOCALISE = tracker.RegisteredPoses._recognised, tracker.relocalise
GUESSED, BETWEEN, LEVEL = predictions.guessed, keyframes.BetweenFactor, keyframes.LevelFactor
EXACT = 1e-8 * np.eye(6)
"""(6, 6) covariance [rad, m] of a pose that is taken as known."""
SINGULAR = 1e-6 * np.eye(6)
"""(6, 6) information that keeps a matrix invertible."""
STARTED = -(10**6)
"""A number of contradicting frames that no run makes up for."""


def _nothing(*_: object, **__: object) -> None:
    """Takes the place of a method that only changes its object, or of one that may find nothing."""


def _no(*_: object, **__: object) -> bool:
    return False


def _yes(*_: object, **__: object) -> bool:
    return True


def _itself(one: Any, *_: object) -> Any:
    """The first argument."""
    return one


def _gate_without(**limits: float) -> Callable[..., Verdict]:
    def verdict(self: GateSettings, *args: Any, **kwargs: Any) -> Verdict:
        return VERDICT(replace(self, **limits), *args, **kwargs)

    return verdict


def _any_overlap(
    self: GateSettings, found: Registration, prior: Any, through: float = 0.0, *_: object
) -> Verdict:
    return VERDICT(self, found, prior, through, 0.0)


def _as_converged(self: GateSettings, found: Registration, *args: Any, **kwargs: Any) -> Verdict:
    return VERDICT(self, replace(found, converged=True), *args, **kwargs)


def _as_known_before(
    self: Placement, scan: Any, found: Registration, before: Belief, expected: Belief
) -> float:
    known = Belief(before.T_map_camera, np.zeros((6, 6)))
    return LEAST_OVERLAP(self, scan, found, known, expected)


def _smallest_distance(attempt: Attempt, below: float, *_: object) -> bool:
    return attempt.verdict.is_open and attempt.distance < below


def _first_candidate(_: Recognition, fits: list[Registration], *__: object) -> Registration | None:
    return fits[0] if fits else None


def _relocalise_with_violations(*args: Any) -> list[Registration]:
    *others, settings, rest_is_news = args
    relocalise: Callable[..., list[Registration]] = RELOCALISE
    return relocalise(*others, replace(settings, most_through=np.inf), rest_is_news)


def _never_lost(self: tracker.RegisteredPoses, *args: Any) -> Attempt | None:
    count, self._doubts = self._doubts, STARTED
    try:
        return RECOGNISED(self, *args)
    finally:
        self._doubts = count


def _never_misled(
    self: wheel_grip.WheelGrip, told: Any, found: Any, slack: Any = wheel_grip.SLACK
) -> bool:
    return slack is not wheels.MISLED and IS_CONTRADICTED(self, told, found, slack)


def _never_broken(self: wheels.Wheels, frame: Any, moved: Any, *_: object) -> None:
    HEARD(self, frame, moved)


def _independent(time: float, settings: Any, *_: object) -> Any:
    return GUESSED(time, settings)


def _nearest(self: Keyframes, T_map_camera: RigidTransform) -> tuple[int, float]:
    apart = self._apart(T_map_camera)
    best = int(apart.argmin())
    self._held = self.numbers[best]
    return self._held, float(apart[best])


def _as_taken(keys: Sequence[Keyframe], *_: object) -> dict[int, Keyframe]:
    return {key.number: key for key in keys}


def _known_first(self: FirstPose, *args: Any) -> Belief:
    return Belief(FIRST_POSE(self, *args).T_map_camera, EXACT)


def _unrobust(first: int, second: int, T: Any, information: Any, **_: object) -> Any:
    return BETWEEN(first, second, T, information)


def _of_no_weight(pose: int, mount: Any, information: Any) -> Any:
    return LEVEL(pose, mount, np.zeros_like(information))


def _unblurred(information: Any, _: object) -> Any:
    return information + SINGULAR


def _pair_prior(*_: object) -> Any:
    return np.diag(keyframe_pairs.BELIEVED_SIGMAS**-2.0)


POSES, GATE = tracker.RegisteredPoses, "gate: "
RULES = (
    Rule(
        "innovation test",
        "(`leap`) A fit far from its prior is accepted.",
        (Patch(placement, "is_hasty", _no, True),),
    ),
    Rule(
        "local-minimum test",
        "(`ambiguity`) A frame is not fitted again from both sides of its optimum.",
        (Patch(placement, "is_ambiguous", _no, True), Patch(tracker, "is_ambiguous", _no, True)),
    ),
    Rule(
        "re-init. check",
        "(`probation`) The map grows again at once after a vague pose or an odd frame.",
        (Patch(Probation, "hear", _nothing),),
    ),
    Rule(
        "reloc. verifier",
        "(`recognition`) The relocalisation candidate with most overlap is accepted at once.",
        (Patch(Recognition, "believed", _first_candidate),),
    ),
    Rule(
        "lost state",
        "(`lost_after`) A contradicting frame is only searched for near its prior.",
        (Patch(POSES, "_recognised", _never_lost),),
    ),
    Rule(
        "relocalisation",
        "(`relocalisation`) A contradicting frame is not searched for among the keyframes.",
        (Patch(POSES, "_recognised", _nothing, True),),
    ),
    Rule(
        "unexplored space",
        "(`news`) Points off the map speak against a fit wherever they lie.",
        (Patch(placement, "rest_is_news", _no, True), Patch(tracker, "rest_is_news", _no, True)),
    ),
    Rule(
        "out-of-place test",
        "(`news`) A lost camera is taken to be elsewhere.",
        (Patch(tracker, "is_out_of_place", _yes, True),),
    ),
    Rule(
        "running statistics",
        "(`usual_frames`) Overlap, inliers and distances of earlier frames are not kept.",
        (Patch(UsualFrames, "hear", _nothing),),
    ),
    Rule(
        "hypothesis test",
        "(`attempt`) The fit nearest to the map is taken, however far it moved.",
        (Patch(Attempt, "wins", _smallest_distance, True),),
    ),
    Rule(
        "further hypotheses",
        "(`attempt`) The fit from the first prior is taken.",
        (Patch(Attempt, "wins", _no, True),),
    ),
    Rule(
        "smoother",
        "(`hindsight`) Unreliable poses are not corrected later; changes final poses only.",
        (Patch(Hindsight, "hear", _nothing, True),),
    ),
    Rule(
        "covariance prop.",
        "(`surest_ways`) Keyframe covariances stay as they were when the keyframe was taken.",
        (Patch(keyframes, "by_surest_ways", _as_taken),),
    ),
    Rule(
        "odometry scale",
        "(`wheel_grip`) The wheels are taken not to slip.",
        (Patch(wheel_grip.WheelGrip, "taught", _itself),),
    ),
    Rule(
        "odometry consistency",
        "(`misled`) Odometry keeps its weight after a step that registration contradicts.",
        (Patch(wheel_grip.WheelGrip, "is_contradicted", _never_misled, True),),
    ),
    Rule(
        "correlated drift",
        "(`unheld`) Errors of successive dead-reckoned steps are independent.",
        (
            Patch(wheels.Wheels, "_further", lambda *_: (0.0, 0.0), True),
            Patch(predictions, "guessed", _independent, True),
        ),
    ),
    Rule(
        "odometry covariance",
        "(`wheel_motion`) The covariance that comes with the odometry is ignored.",
        (Patch(wheel_motion, "_grown", lambda *_: np.zeros((3, 3)), True),),
    ),
    Rule(
        "broken segments",
        "(`broken`) Odometry links the keyframes on both sides of a contradicting frame.",
        (Patch(wheels.Wheels, "heard", _never_broken),),
    ),
    Rule(
        "odometry refit",
        "(`grip`) Keyframes linked by odometry are not fitted again at the end.",
        (Patch(Keyframes, "_is_held_by_wheels", _no, True),),
    ),
    Rule(
        "culled keyframes",
        "(`heirs`) Poses at culled keyframes are not corrected. More than 240 keyframes only.",
        (Patch(Heirs, "gave_way", _nothing),),
    ),
    Rule(
        f"{GATE}few points",
        "(`gate`) Frames with few points or inliers are judged like all others.",
        (Patch(GateSettings, "verdict", _gate_without(fewest_points=0, fewest_inliers=0), True),),
    ),
    Rule(
        f"{GATE}overlap",
        "(`gate`) No share of the frame has to lie on the map.",
        (Patch(GateSettings, "verdict", _any_overlap, True),),
    ),
    Rule(
        f"{GATE}overlap, vague",
        "(`placement`) A vague prior demands no more overlap than another one.",
        (Patch(Placement, "_least_overlap", _as_known_before, True),),
    ),
    Rule(
        f"{GATE}free space",
        "(`gate`) Free-space violations speak against no pose, nor against a candidate.",
        (
            Patch(GateSettings, "verdict", _gate_without(most_through=np.inf), True),
            Patch(tracker, "relocalise", _relocalise_with_violations),
        ),
    ),
    Rule(
        "excluded violations",
        "(`phantoms`) What keyframes look through stays in the free-space test.",
        (Patch(placement, "violated_points", lambda *_: np.empty(0, np.int64), True),),
    ),
    Rule(
        f"{GATE}residual",
        "(`misfit`) Large residuals speak against no pose.",
        (Patch(GateSettings, "verdict", _gate_without(largest_misfit=np.inf), True),),
    ),
    Rule(
        f"{GATE}Mahalanobis",
        "(`gate`) A fit may contradict its prior.",
        (Patch(GateSettings, "verdict", _gate_without(farthest=np.inf), True),),
    ),
    Rule(
        f"{GATE}convergence",
        "(`gate`) Fits that have not converged are accepted.",
        (Patch(GateSettings, "verdict", _as_converged, True),),
    ),
    Rule(
        f"{GATE}weak direction",
        "(`gate`) A fit counts as complete if the map leaves one direction free.",
        (Patch(GateSettings, "verdict", _gate_without(weakest=np.inf), True),),
    ),
    Rule(
        "whole gate",
        "(`gate`) All rows `gate` together: every fit is accepted.",
        (Patch(GateSettings, "verdict", lambda *_: Verdict(), True),),
    ),
    Rule(
        "added uncertainty",
        "(`doubt`) A contradicting frame leaves the covariance as it is.",
        (Patch(Attempt, "doubted", _itself),),
    ),
    Rule(
        "covariance bound",
        "(`certain`) Poses of any covariance are reliable, and extend the map.",
        (Patch(POSES, "_is_known", _yes, True),),
    ),
    Rule(
        "reliability",
        "(`certain`) All poses are reliable, and extend the map.",
        (Patch(POSES, "_doubt", lambda *_: "", True),),
    ),
    Rule(
        "levelness",
        "(`held_to_floor`) The base may stand at any height and tilt. Needs a mount.",
        (
            Patch(Belief, "held_to_floor", _itself),
            Patch(keyframes, "LevelFactor", _of_no_weight),
        ),
    ),
    Rule(
        "floor normals",
        "(`keyframe`) Normals of the floor are those of its points. Needs a mount.",
        (Patch(ScanSurface, "with_vertical_floor_normals", _itself),),
    ),
    Rule(
        "velocity prior",
        "(`recent_motion`) In place of a constant velocity the camera stands still.",
        (Patch(RecentMotion, "going_on", lambda *_: RigidTransform.identity()),),
    ),
    Rule(
        "first pose",
        "(`first_pose`) The first pose is known exactly.",
        (Patch(FirstPose, "at", _known_first),),
    ),
    Rule(
        "reference keyframe",
        "(`holding`) The nearest keyframe is the reference, before and after a loop closure.",
        (Patch(Keyframes, "holding", _nearest),),
    ),
    Rule(
        "pair prior",
        "(`by_tracking`) Keyframes are linked by their fit alone, with a weak prior.",
        (Patch(keyframe_pairs, "by_tracking", _pair_prior),),
    ),
    Rule(
        "view-angle noise",
        "(`worth_by_view`) Fits of views from two sides count like all others.",
        (Patch(keyframe_pairs, "worth_by_view", _unblurred),),
    ),
    Rule(
        "robust kernel",
        "(`robust`) All between factors have a quadratic kernel.",
        (Patch(keyframe_pairs, "BetweenFactor", _unrobust),),
    ),
    Rule(
        "factor agreement",
        "(`agreeing`) All between factors lower covariances, outliers included.",
        (Patch(keyframes, "agreeing", lambda edges, *_: list(edges), True),),
    ),
    Rule(
        "loop closure",
        "(`showing_the_same`) Only consecutive keyframes are linked.",
        (Patch(keyframes, "showing_the_same", lambda *_: [], True),),
    ),
    Rule(
        "pose graph",
        "(`correct`) Keyframes stay where they were taken.",
        (Patch(Keyframes, "correct", _no),),
    ),
)  # fmt: skip
"""In the order in which they are switched off together."""
