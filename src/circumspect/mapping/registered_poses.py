"""Poses by registration of every frame to the scene, fused with odometry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.geometry.composition import between, composed
from circumspect.mapping import motion
from circumspect.mapping.ambiguity import is_ambiguous
from circumspect.mapping.attempt import Attempt
from circumspect.mapping.first_pose import FirstPose
from circumspect.mapping.gate import Verdict
from circumspect.mapping.hindsight import Hindsight
from circumspect.mapping.keyframes import Keyframes
from circumspect.mapping.leap import BETTER
from circumspect.mapping.motion import Belief
from circumspect.mapping.news import is_out_of_place, rest_is_news
from circumspect.mapping.placement import KNOWN, Placement
from circumspect.mapping.pose_estimator import LOST, PoseEstimate, PoseEstimator
from circumspect.mapping.predictions import Predictions
from circumspect.mapping.probation import Probation
from circumspect.mapping.recognition import Recognition
from circumspect.mapping.relocalisation import nearby, relocalise
from circumspect.mapping.tracking_settings import TrackingSettings
from circumspect.registration import Registration, Scan, SurfaceMap
from circumspect.sensing import RgbdFrame

RECOGNISED = "a place seen before"
STEADY, STANDING = motion.CONSTANT_VELOCITY, motion.STANDING_STILL
ANYWHERE = np.eye(6)
"""(6, 6) covariance [rad, m] of a camera that may be anywhere."""


class RegisteredPoses(PoseEstimator):
    """Follows a camera by scan-to-model registration from the odometry prior.

    The map frame is the odom frame of the first frame; without odometry it is the frame in which
    the first pose is given.
    """

    def __init__(
        self,
        T_map_first: RigidTransform | None = None,
        settings: TrackingSettings | None = None,
    ) -> None:
        """Begin with an empty map.

        Args:
            T_map_first: Pose of the first frame; None means that of the first frame's odometry
                and mount, or else the one that the first frame brings, or else its mount: the
                map begins under the robot.
            settings: How frames are followed.
        """
        self.settings = settings or TrackingSettings()
        self._first_pose = FirstPose(T_map_first)
        s = self.settings
        bumps = [s.motion.bump_turn, s.motion.bump_turn, s.motion.bump_height]
        self.keyframes = Keyframes(
            s.scan.voxel, s.keyframes, s.registration, s.gate, np.diag(np.array(bumps) ** -2.0)
        )
        self._placement = Placement(s, self.keyframes)
        self._usual = self._placement.usual
        self._belief: Belief | None = None
        self._stamp = 0.0
        self._predictions = Predictions(s.motion)
        self._recognition = Recognition(s.relocalisation, s.gate.farthest)
        self._probation = Probation(s.relocalisation.confirmed, KNOWN * s.registration.max_distance)
        self._hindsight = Hindsight()
        self._source = ""
        self._doubts = 0
        self._loops = 0
        self._is_due = False  # a correction, beside the next frame
        self._jobs = 0  # looks, and what else this frame brought
        self._left: Callable[[], None] | None = None
        self._is_settled = False  # no frame came since

    @property
    def scene(self) -> SurfaceMap:
        """What frames are fitted to, once it has caught up."""
        return self._placement.scene

    def estimate(self, frame: RgbdFrame) -> PoseEstimate:
        """See `PoseEstimator.estimate`."""
        scan = Scan.from_frame(frame, self.settings.scan)
        self.catch_up()
        self._jobs, self._is_settled = 0, False
        if self._belief is None:
            return self._first(frame, scan)

        # Where the camera should be, and what the frame says to it
        before, best = self._belief, self._best_attempt(frame, scan)
        expected = best.prediction or best.belief

        # A frame that fits nowhere near: perhaps the robot was carried off
        if best.verdict.contradicts:
            best = self._recognised(frame, scan, best.belief) or best
        elif best.verdict.mute:
            # A doubt is not removed by a frame that says nothing.
            self._recognition.carry(between(self._belief.T_map_camera, best.belief.T_map_camera))
        else:
            self._recognition.forget()
        if best.verdict.contradicts:
            best = best.doubted(self.settings.doubt)
            expected = best.belief
            self._doubts += 1
        elif not best.verdict.mute:
            self._doubts = 0
        self._probation.hear(best, self._is_known(self._belief))
        self._remember(frame, best)
        self._left = partial(self._work_on, frame, scan, best)
        unsure = self._hindsight.hear(before, expected, best.belief, self._is_certain(best))
        return replace(self._told(frame, best), unsure=unsure)

    def pass_over(self, frame: RgbdFrame) -> None:
        """See `PoseEstimator.pass_over`: until there is a map, the wheels tell where it begins."""
        if self._belief is None:
            self._first_pose.pass_over(frame)

    def catch_up(self) -> None:
        """See `PoseEstimator.catch_up`: the map is corrected, and grows by the last frame."""
        left, self._left = self._left, None
        if left is not None:
            left()

    def _work_on(self, frame: RgbdFrame, scan: Scan, attempt: Attempt) -> None:
        """What a frame that was told leaves to be done."""
        if self._is_due:
            self._correct(anyway=False)
        # A direction that the scene does not hold is held by the wheels for a while.
        if self._is_certain(attempt) and len(scan) >= self.settings.gate.fewest_points:
            self._grow(frame, scan, attempt)

    def _first(self, frame: RgbdFrame, scan: Scan) -> PoseEstimate:
        belief = self._first_pose.at(frame, self.settings.motion)
        first = Attempt(belief, Verdict(), "first frame")
        self._remember(frame, first)
        if len(scan) >= self.settings.gate.fewest_points:
            self._grow(frame, scan, first)
        else:
            # Nothing to begin a map with.
            first = replace(first, verdict=Verdict(f"{len(scan)} points in range"))
            self._belief = None
        return self._told(frame, first)

    def _best_attempt(self, frame: RgbdFrame, scan: Scan) -> Attempt:
        """By odometry; where that is doubtful, also as if the last motion just went on."""
        assert self._belief is not None
        expected, time = self._predictions, frame.stamp - self._stamp
        wheels = expected.by_wheels(self._belief, frame)
        if wheels is None:
            return self._without_wheels(frame, scan, time)
        steady = expected.by_steady_motion(self._belief, frame, time)
        agree = motion.agree(self._belief, wheels, steady)
        first = self._attempt(frame, scan, wheels, motion.ODOMETRY)
        usual = self._usual.most_distance
        if agree and first.distance < usual and not first.verdict.contradicts:
            return first
        # Odometry that misled once must fit clearly better before it is trusted again.
        share = 1 / BETTER if self._source == STEADY else BETTER
        below = np.inf if first.verdict.contradicts else share * first.distance
        second = self._attempt(frame, scan, steady, STEADY, below)
        in_order = not (first.verdict.contradicts or first.verdict.mute)
        return second if second.wins(below, usual, in_order, steady, wheels) else first

    def _without_wheels(self, frame: RgbdFrame, scan: Scan, time: float) -> Attempt:
        """As if the last motion just went on; where that is doubtful, also as if it had ended."""
        assert self._belief is not None
        steady = self._predictions.by_steady_motion(self._belief, frame, time)
        first = self._attempt(frame, scan, steady, STEADY)
        usual = self._usual.most_distance
        if first.verdict.is_open and first.distance < usual:
            return first
        standing = self._predictions.by_standing_still(self._belief, frame, time)
        if motion.agree(self._belief, steady, standing):
            return first
        in_order = first.verdict.is_open
        below = BETTER * first.distance if in_order else np.inf
        second = self._attempt(frame, scan, standing, STANDING, below)
        return second if second.wins(below, usual, in_order, standing, steady) else first

    def _attempt(
        self, frame: RgbdFrame, scan: Scan, believed: Belief, source: str, below: float = np.inf
    ) -> Attempt:
        assert self._belief is not None
        self._jobs += 1
        return self._placement.attempt(frame, scan, self._belief, believed, source, below)

    def _recognised(self, frame: RgbdFrame, scan: Scan, expected: Belief) -> Attempt | None:
        """The frame among all keyframes, where it fits one place beyond doubt."""
        s = self.settings
        assert self._belief is not None
        self._jobs += 1
        lost = self._doubts + 1 >= s.lost_after
        places, rules = self.keyframes.places, s.relocalisation
        if not lost:
            places = nearby(places, expected.T_map_camera)
            # Before news less of a frame is known, as of the last ones.
            known = min(rules.least_known, s.keeps_overlap * self._usual.overlap)
            rules = replace(rules, least_known=known)
        reach = s.registration.max_distance
        fits = relocalise(
            partial(self._placement.seen_through, frame), scan, self.scene,
            expected.T_map_camera, places, s.registration, s.gate, rules,
            lambda fit, contrary: rest_is_news(
                scan, fit, self.scene, self.keyframes, reach, contrary
            ),
        )  # fmt: skip
        moved = between(self._belief.T_map_camera, expected.T_map_camera)
        elsewhere = lost and is_out_of_place(
            scan, expected.T_map_camera, self.scene, self.keyframes, reach
        )
        found = self._recognition.believed(
            fits, expected, moved, self._usual.inliers, lost, elsewhere,
            partial(self._fits_aside, scan),
        )  # fmt: skip
        if found is None:
            return None
        self.keyframes.found_again()
        belief = Belief(found.T_map_camera, np.linalg.inv(found.information))
        return Attempt(belief, Verdict(), RECOGNISED, found)

    def _fits_aside(self, scan: Scan, fit: Registration) -> bool:
        """Whether a frame that may be anywhere fits elsewhere as well."""
        anywhere = Belief(fit.T_map_camera, ANYWHERE)
        return is_ambiguous(scan, self.scene, fit, anywhere, self.settings.registration)

    def _remember(self, frame: RgbdFrame, attempt: Attempt) -> None:
        moved, held = None, attempt.verdict.is_open and attempt.found is not None
        recognised, contradicts = attempt.source == RECOGNISED, attempt.verdict.contradicts
        if self._belief is not None and not recognised:
            moved = between(self._belief.T_map_camera, attempt.belief.T_map_camera)
        self._predictions.wheels.heard(frame, moved if held else None, recognised or contradicts)
        time = frame.stamp - self._stamp
        self._predictions.passed(time, self._belief is None or held)
        if moved is not None and not contradicts:
            self._predictions.recent.add(moved, time)
        elif recognised or self._doubts >= self.settings.lost_after:
            # A lost camera does not drive on as it did when it was last seen.
            self._predictions.recent.forget()
        if held and attempt.found is not None:
            self._usual.hear(attempt.found)
        self._source = attempt.source
        self._belief, self._stamp = attempt.belief, frame.stamp

    def _grow(self, frame: RgbdFrame, scan: Scan, attempt: Attempt) -> None:
        """Take a new keyframe in, and work a little on what the last ones are to be fitted to."""
        assert self._belief is not None
        keys, T_map_camera = self.keyframes, self._belief.T_map_camera
        keys.grip = self._predictions.wheels.grip
        is_news = len(keys) == 0 or keys.holding(T_map_camera)[1] >= 1
        if is_news:
            covariance = self._belief.covariance
            found = attempt.found
            by_scene = found.hessian if found is not None and found.converged else None
            passage = self._predictions.wheels.at_keyframe(by_scene)
            key = keys.add(T_map_camera, covariance, scan, frame, passage)
            self._placement.scene = self.scene.with_surface(key.surface, T_map_camera)
            self._placement.hear(frame, T_map_camera)
            self._jobs += 1
        # A keyframe, a second look or a correction is work enough, unless too many pairs wait.
        hurry = keys.queue.is_crowded
        pairs = min(2 if hurry else int(self._jobs == 1), len(keys.queue))
        for _ in range(pairs):
            keys.fit_next(hurry)
        # Neighbours along the way say little that the map does not say; a closed loop does.
        waits = keys.queue.holds_up if hurry else len(keys.queue) > 0
        self._is_due = pairs > 0 and keys.loops > self._loops and not waits

    def _correct(self, anyway: bool) -> None:
        """Move the keyframes to where their graph says, and what hangs on them."""
        assert self._belief is not None
        self._loops, self._is_due = self.keyframes.loops, False
        self._jobs += 1
        T_map_camera = self._belief.T_map_camera
        number, _ = self.keyframes.holding(T_map_camera)
        T_anchor_camera = between(self.keyframes[number].T_map_camera, T_map_camera)
        if not self.keyframes.correct(anyway):
            return
        moved = self.keyframes.anchored(number, T_anchor_camera)
        self._belief = Belief(moved, self._belief.covariance)
        self._placement.scene = self.keyframes.scene()

    @property
    def corrections(self) -> int:
        """See `PoseEstimator.corrections`."""
        return self.keyframes.corrections

    def corrected(self, told: Sequence[PoseEstimate]) -> list[RigidTransform]:
        """See `PoseEstimator.corrected`."""
        return [self._now(estimate) for estimate in told]

    def _now(self, estimate: PoseEstimate) -> RigidTransform:
        T_map_camera = estimate.T_map_camera
        if estimate.anchor is not None and estimate.T_anchor_camera is not None:
            # What was forgotten long ago stays where it was told to be.
            with suppress(KeyError):
                T_map_camera = self.keyframes.anchored(estimate.anchor, estimate.T_anchor_camera)
        if estimate.unsure is None:
            return T_map_camera
        return self._hindsight.seen(T_map_camera, estimate.unsure)

    def anchor_pose(self, number: int) -> RigidTransform:
        """See `PoseEstimator.anchor_pose`."""
        return self.keyframes.anchored(number, RigidTransform.identity())

    def settle(self) -> None:
        """See `PoseEstimator.settle`."""
        self.catch_up()
        if self._is_settled or len(self.keyframes) < 2:
            return
        while len(self.keyframes.queue):
            self.keyframes.fit_next()
        self.keyframes.fit_what_wheels_held()
        self._correct(anyway=True)
        self._is_settled = True  # not before: who interrupts it may settle again

    def _is_certain(self, attempt: Attempt) -> bool:
        """Whether to build on it: nothing speaks against it, and it is known well enough."""
        return not self._doubt(attempt)

    def _doubt(self, attempt: Attempt) -> str:
        """Why not to build on it; empty where nothing speaks against that."""
        if self._doubts:
            return f"{_frames(self._doubts)} contradicted what is known"
        if not self._is_known(attempt.belief):
            known, needed = _shown(attempt.belief.sigmas), _shown(self.settings.certain)
            return f"known to {known}; {needed} are needed"
        if left := self._probation.left:
            return f"{_frames(left)} must agree first"
        return ""

    def _is_known(self, belief: Belief) -> bool:
        turn, place = belief.sigmas
        return turn < self.settings.certain[0] and place < self.settings.certain[1]

    def _told(self, frame: RgbdFrame, attempt: Attempt) -> PoseEstimate:
        believed = self._belief or attempt.belief
        found, verdict = attempt.told, attempt.verdict
        T_map_base = T_map_odom = None
        if frame.T_base_camera is not None:
            T_map_base = PlanarPose.from_transform(
                composed(believed.T_map_camera, frame.T_base_camera.inv())
            )
            if frame.odometry is not None:
                T_map_odom = T_map_base @ frame.odometry.T_odom_base.inverse()
        number = T_anchor_camera = None
        if len(self.keyframes):
            number, _ = self.keyframes.holding(believed.T_map_camera)
            T_anchor_camera = between(self.keyframes[number].T_map_camera, believed.T_map_camera)
        lost = self._doubts >= self.settings.lost_after
        doubt = "no map yet" if self._belief is None else self._doubt(attempt)
        return PoseEstimate(
            believed.T_map_camera,
            converged=verdict.is_open if found is None else found.converged,
            inliers=0 if found is None else found.inliers,
            residual=0.0 if found is None else found.residual,
            gate=f"{LOST}{verdict.reason}" if lost else verdict.reason,
            covariance=self.keyframes.covariance(believed.T_map_camera, believed.covariance),
            T_map_base=T_map_base,
            T_map_odom=T_map_odom,
            doubt=doubt,
            prior=attempt.source,
            anchor=number,
            T_anchor_camera=T_anchor_camera,
        )


def _shown(sigmas: tuple[float, float]) -> str:
    turn, place = sigmas
    return f"{np.degrees(turn):.1f}° and {1e3 * place:.0f} mm"


def _frames(count: int) -> str:
    return "a frame" if count == 1 else f"{count} frames"
