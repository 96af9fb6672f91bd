"""A robot drives round an object, models it and names it (section 3.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry import PlanarPose
from circumspect.pipeline.progress_watch import ProgressWatch
from circumspect.pipeline.recognition_pipeline import RecognitionPipeline
from circumspect.pipeline.records import CLASSIFIED, RecognitionResult, RecognitionStep
from circumspect.pipeline.scan_settings import ScanSettings
from circumspect.pipeline.view_record import BLOCKED, CLOSED, REACHED, UNSURE, ViewRecord
from circumspect.pipeline.whereabouts import Whereabouts
from circumspect.planning import (
    Finished,
    NextView,
    NoWay,
    Route,
    Situation,
    ViewPlanner,
    alternatives,
    passable,
    route,
    sectors_visited,
)
from circumspect.robot import MobileRobot, PathFollower, Velocity
from circumspect.sensing import RgbdFrame

LOST = "lost: no frame can be placed any more"
INTERRUPTED = "interrupted"
TRIES = 2
"""So often a view is tried that something comes in between of."""
LOOK_ROUND = 1.1
"""A look round is this many turns."""
BUMP_XY = np.array([[0.3, side] for side in (-0.2, -0.1, 0.0, 0.1, 0.2)])
"""What a blocked robot takes to be in its way, in its own frame [m]."""
NOTHING_XY = np.empty((0, 2))


class ScanOver(Exception):  # noqa: N818 - no fault, but the end
    """Raised inside the scan to end it; its message is the reason."""


class ObjectScan:
    """The loop of section 3.1: look, register, fuse, name, plan, drive.

    Attributes:
        robot: What drives and looks.
        pipeline: What registers, fuses and names.
        planner: What chooses views.
        settings: How it drives and when it gives up.
        ended: Why the scan ended; None while it goes on.
        views: What became of the views chosen so far.
        driven_m: What the wheels say was driven [m].
        frame: The latest frame.
    """

    def __init__(
        self,
        robot: MobileRobot,
        pipeline: RecognitionPipeline,
        planner: ViewPlanner,
        settings: ScanSettings | None = None,
    ) -> None:
        """Put the parts together; nothing moves yet.

        Args:
            robot: Stands anywhere.
            pipeline: Its observers are told of every step and of the end.
            planner: Chooses views.
            settings: See `ScanSettings`.
        """
        self.robot = robot
        self.pipeline = pipeline
        self.planner = planner
        self.settings = settings or ScanSettings()
        self.ended: str | None = None
        self.views: list[ViewRecord] = []
        self.driven_m = 0.0
        self.frame: RgbdFrame | None = None
        turn = min(robot.max_turn, self.settings.max_turn)
        self._follower = PathFollower(max_turn=turn)
        self._whereabouts = Whereabouts(robot.T_base_camera)
        self._frames_taken = 0
        self._in_view = False
        self._probabilities: list[Mapping[str, float]] = []
        self._shares_seen: list[float] = []
        self._visited: list[PlanarPose] = []
        self._unreachable: list[NextView] = []
        self._given_up: list[NextView] = []
        self._bumps_xy = NOTHING_XY
        self._blocks = 0
        self._failed = 0
        self._due = robot.now
        self._placed = robot.now

    def run(self) -> RecognitionResult:
        """Scan until there is a reason to end, which `ended` then tells.

        Whatever ends it, Ctrl-C included, the robot stops and the observers get what was gathered.
        """
        told = self.pipeline.observers
        self.pipeline.observers = (_Listener(self), *told)
        try:
            return self.pipeline.run(self._frames())
        finally:
            self.pipeline.observers = told
            self.robot.stop()

    def _frames(self) -> Iterator[RgbdFrame]:
        """The algorithm: each frame goes through the pipeline before the robot moves on."""
        try:
            yield from self._look_round("no object in view after a look round")
            while True:
                view = self.planner.next_view(self.situation)
                if isinstance(view, Finished):
                    raise ScanOver(self._explained(view))
                view, way = self._way_to(view)
                if isinstance(way, NoWay):
                    self._record(view, way.why)
                    continue
                yield from self._drive(view, way)
                yield from self._look_round("the object is in view no more after a look round")
        except ScanOver as over:
            self.ended = str(over)

    # ── where things are ─────────────────────────────────────────────────────────────────

    @property
    def situation(self) -> Situation:
        """What the planner is told."""
        points, normals = np.empty((0, 3)), np.empty((0, 3))
        try:
            cloud = self.pipeline.model.cloud()
            points, normals = cloud.points_xyz, cloud.normals_xyz
        except GeometryError:
            pass  # Nothing is known of the object yet, and that is what the planner is told.
        return Situation(
            points_xyz=points,
            normals_xyz=np.zeros_like(points) if normals is None else normals,
            T_map_base=self.T_map_base,
            T_base_camera=self.robot.T_base_camera,
            camera=self.robot.camera.intrinsics,
            obstacles_xy=np.vstack([self._obstacles_xy(), self._bumps_xy]),
            robot_radius=self.robot.radius,
            visited=tuple(self._visited),
            unreachable=tuple(self._unreachable),
            given_up=tuple(self._given_up),
            probabilities=tuple(self._probabilities),
            shares_seen=tuple(self._shares_seen),
        )

    @property
    def T_map_base(self) -> PlanarPose:
        """Where the robot believes to be."""
        return self._whereabouts.T_map_base(self.robot.odometry())

    @property
    def turned_deg(self) -> float:
        """On how much of the way round the object the robot has been, 0 … 360 [degrees]."""
        return 360 * float(sectors_visited(self.situation).mean())

    @property
    def _unsure(self) -> bool:
        """Whether no frame could be placed with certainty for long."""
        return self.robot.now - self._placed > self.settings.unsure_after

    def _obstacles_xy(self) -> NDArray[np.float64]:
        return NOTHING_XY

    # ── driving ──────────────────────────────────────────────────────────────────────────

    def _way_to(self, view: NextView) -> tuple[NextView, Route | NoWay]:
        """The way to a view, or to a similar one, or the reason why there is none."""
        situation = self.situation
        first = way = route(situation, view.T_map_base, self.settings.keep)
        if isinstance(first, Route):
            return view, first
        for other in alternatives(view, self.robot.T_base_camera):
            way = route(situation, other.T_map_base, self.settings.keep)
            if isinstance(way, Route):
                return other, way
        return view, first

    def _drive(self, view: NextView, way: Route) -> Iterator[RgbdFrame]:
        """Follow a way, taking frames, until the view is reached or something is in between."""
        watch = ProgressWatch(self.settings.stuck_after)
        frame, outcome = self.frame, REACHED
        while outcome == REACHED and (velocity := self._velocity(view, way)) is not None:
            yield from self._tick(velocity)
            if watch.stuck(self.robot.now, self.T_map_base):
                outcome = BLOCKED
            elif self._unsure:
                outcome = UNSURE
            elif self.frame is not frame and not passable(self.situation, way.path_xy):
                outcome = CLOSED
            frame = self.frame
        self.robot.stop()
        self._record(view, outcome, way)
        if outcome == BLOCKED:
            yield from self._back_off()

    def _velocity(self, view: NextView, way: Route) -> Velocity | None:
        return self._follower.velocity(
            self.T_map_base, way.path_xy, view.T_map_base, self.settings.speed
        )

    def _back_off(self) -> Iterator[RgbdFrame]:
        """Remember what is in the way and go back a little."""
        self._blocks += 1
        if self._blocks > self.settings.most_blocks:
            raise ScanOver(f"blocked {self._blocks} times: nothing more can be reached")
        self._bumps_xy = np.vstack([self._bumps_xy, self.T_map_base.applied(BUMP_XY)])
        s = self.settings
        for _ in range(round(s.back_off / s.speed / s.tick)):
            yield from self._tick(Velocity(-s.speed))
        self.robot.stop()

    def _record(self, view: NextView, outcome: str, way: Route | None = None) -> None:
        """Keep what became of a view; what has no way, or failed twice, is not tried again."""
        path = NOTHING_XY if way is None else way.path_xy
        self.views.append(ViewRecord(view, outcome, path, self._frames_taken))
        if outcome == REACHED:
            self._unreachable.clear()
            self._failed = 0
            return
        self._failed += 1
        if way is None or self._failed >= TRIES:
            self._unreachable.append(view)
            self._given_up.append(view)

    def _explained(self, finished: Finished) -> str:
        """Why the planner finished; with the last hindrance where views were left out."""
        if not self._unreachable:
            return finished.why
        return f"{finished.why} ({self.views[-1].outcome})"

    def _look_round(self, otherwise: str) -> Iterator[RgbdFrame]:
        """Turn on the spot until the object is in view.

        Args:
            otherwise: Why the scan ends when it is nowhere.
        """
        turn = Velocity(0.0, self._follower.max_turn)
        yield from self._look()
        turned = 0.0
        while not self._in_view:
            if turned > LOOK_ROUND * 2 * np.pi:
                raise ScanOver(LOST if self._unsure else otherwise)
            yield from self._tick(turn)
            turned += turn.turn * self.settings.tick
        self.robot.stop()

    # ── time and frames ──────────────────────────────────────────────────────────────────

    def _tick(self, velocity: Velocity) -> Iterator[RgbdFrame]:
        """Drive for one tick, and take a frame when it is time."""
        before = self.robot.odometry()
        self.robot.drive(velocity)
        self.robot.wait(self.settings.tick)
        self._whereabouts.moved(velocity, self.settings.tick)
        after = self.robot.odometry()
        step = most = abs(velocity.forward) * self.settings.tick
        if before is not None and after is not None:
            step = float(np.linalg.norm(after.T_odom_base.xy - before.T_odom_base.xy))
        # Odometry that jumps is no way driven.
        self.driven_m += min(step, 2 * most)
        if self.robot.now >= self._due - 1e-6:
            yield from self._look()

    def _look(self) -> Iterator[RgbdFrame]:
        """Take a frame; once it went through the pipeline, see whether to go on."""
        self._due = self.robot.now + self.settings.frame_interval
        self.frame = self.robot.observe()
        yield self.frame
        if self._frames_taken >= self.settings.most_frames:
            raise ScanOver(f"the limit of {self.settings.most_frames} frames is reached")
        if self._in_view and (finished := self.planner.enough(self.situation)) is not None:
            raise ScanOver(finished.why)

    def heard(self, step: RecognitionStep) -> None:
        """Take what a frame led to."""
        self._frames_taken += 1
        self._in_view = step.outcome == CLASSIFIED
        if self._in_view and step.prediction is not None:
            self._probabilities.append(step.prediction.probabilities)
            self._shares_seen.append(step.seen)
        if step.pose is None or self.frame is None:
            return
        if step.pose.certain:
            self._placed = self.robot.now
        self._whereabouts.corrected(step.pose, self.frame.odometry)
        self._visited.append(self.T_map_base)


class _Listener:
    """Hands the pipeline's steps to the scan; a `PipelineObserver`."""

    def __init__(self, scan: ObjectScan) -> None:
        self._scan = scan

    def on_step(self, step: RecognitionStep) -> None:
        self._scan.heard(step)

    def on_end(self, result: RecognitionResult) -> None:
        if result.interrupted:
            self._scan.ended = INTERRUPTED
