"""A robot drives round an object, models it and names it (section 3.1)."""

from __future__ import annotations

from collections.abc import Callable, Generator

import numpy as np

from circumspect.exploration.distance_meter import DrivenWay
from circumspect.exploration.exploration_state import ScanKnowledge
from circumspect.exploration.progress_watch import ProgressWatch
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.exploration.view_record import (
    BLOCKED,
    CLOSED,
    HIDDEN,
    NO_NEWS,
    REACHED,
    UNSURE,
    ViewRecord,
)
from circumspect.geometry import PlanarPose
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
from circumspect.recognition.recognition_pipeline import RecognitionPipeline
from circumspect.recognition.recognition_step import (
    OUT_OF_ORDER,
    RecognitionResult,
    RecognitionStep,
)
from circumspect.recognition.stage_clock import StageClock, timed
from circumspect.robot import MobileRobot, PathFollower, Velocity
from circumspect.sensing import Odometry, RgbdFrame

LOST = "lost: no pose has been reliable for too long"
NO_OBJECT_ANYWHERE = "no object in view after a look round"
INTERRUPTED = "interrupted"
TRIES = 2
"""So often a view is tried that something comes in between of."""
LOOKS = 2
"""So many more frames are taken from a view that does not show the object."""
LOOK_ROUND = 1.1
"""A look round is this many turns."""
NO_PATH = np.empty((0, 2))

Frames = Generator[RgbdFrame, None, None]


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
        frame: The latest frame.
        clock: Of what comes between two frames.
        plan_milliseconds: Time spent on the map of obstacles, views and ways, one a frame [ms].
        target: The view that the robot drives to; None before the first.
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
        self.frame: RgbdFrame | None = None
        self.clock = StageClock()
        self.plan_milliseconds: list[float] = []
        self.target: NextView | None = None
        turn = min(robot.max_turn, self.settings.max_turn)
        self._follower = PathFollower(max_turn=turn)
        self._known = ScanKnowledge(robot)
        self._way = DrivenWay()
        self._blocks = self._failures = 0
        self._unplaced: list[Velocity] = []
        self._looked = self._due = robot.now

    @property
    def situation(self) -> Situation:
        """What the planner is told."""
        return self._known.situation(self.pipeline.model)

    @property
    def T_map_base(self) -> PlanarPose:
        """Where the robot believes to be."""
        return self._known.T_map_base

    @property
    def driven_m(self) -> float:
        """How far the robot drove until now [m]."""
        return self._way.metres

    @property
    def turned_deg(self) -> float:
        """On how much of the way round the object the robot has been, 0 … 360 [degrees]."""
        return 360 * float(sectors_visited(self.situation).mean())

    def run(self) -> RecognitionResult:
        """Scan until there is a reason to end, which `ended` then tells.

        Whatever ends it, Ctrl-C included, the robot stops, and then the observers get what was
        gathered.
        """
        told = self.pipeline.observers
        self.pipeline.observers = (_Listener(self), *told)
        try:
            return self.pipeline.run(self._frames())
        finally:
            self.pipeline.observers = told
            self.robot.stop()

    def _frames(self) -> Frames:
        """The algorithm: each frame goes through the pipeline before the robot moves on.

        However it ends, closed from outside included, the robot stops at once.
        """
        try:
            # Find the object
            yield from self._look()
            yield from self._turn_until(lambda: self._known.in_view, NO_OBJECT_ANYWHERE)
            while True:
                # Where to look from next
                view = self._next_view()

                # How to get there
                view, way = self._way_to(view)
                if isinstance(way, NoWay):
                    self._record(view, way.why)
                    continue

                # Drive there, looking all the time
                self.target = view
                yield from self._drive(view, way)
                yield from self._turn_until(lambda: self._known.reliable, LOST)
        except ScanOver as over:
            self.ended = str(over)
        finally:
            self.robot.stop()

    @timed("plan")
    def _next_view(self) -> NextView:
        """The planner's choice."""
        view = self.planner.next_view(self.situation)
        if isinstance(view, Finished):
            raise ScanOver(self._explained(view))
        return view

    @timed("plan")
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

    def _drive(self, view: NextView, way: Route) -> Frames:
        """Follow a way, taking frames, until the view is reached or something comes in between."""
        watch, outcome = ProgressWatch(self.settings.stuck_after), REACHED
        frames = self._known.frames
        while outcome == REACHED and (velocity := self._velocity(view, way)) is not None:
            frame = self.frame
            yield from self._tick(velocity)
            # Between frames the wheels tell where the robot is, and they may turn in vain.
            if self.frame is not frame:
                outcome = self._hindrance(way, watch)
        self._stop()
        if outcome == REACHED:
            yield from self._stand_and_look()
            outcome = REACHED if self._known.in_view else HIDDEN
            # Who learns nothing there chooses the same view for ever.
            outcome = outcome if self._known.frames > frames else NO_NEWS
        self._record(view, outcome, way)
        if outcome == BLOCKED:
            yield from self._back_off()
        # What was commanded in vain is not to be taken back: nobody knows what is behind.
        elif outcome == UNSURE or self._known.doubted_for:
            yield from self._retrace()

    def _stand_and_look(self) -> Frames:
        """Take a frame from here; a few where the first ones come late or empty."""
        if self.robot.now > self._looked:
            yield from self._look()
        for _ in range(LOOKS):
            if self._known.in_view:
                return
            self.robot.wait(self.settings.frame_interval)
            yield from self._look()

    def _velocity(self, view: NextView, way: Route) -> Velocity | None:
        return self._follower.velocity(
            self.T_map_base, way.path_xy, view.T_map_base, self.settings.speed
        )

    @timed("plan")
    def _hindrance(self, way: Route, watch: ProgressWatch) -> str:
        """What keeps the robot from going on; `REACHED` where nothing does."""
        if watch.stuck(self.robot.now - self.robot.held, self.T_map_base):
            return BLOCKED
        known, settings = self._known, self.settings
        if known.doubted_for > settings.unsure_after or known.blind_for > settings.blind_after:
            return UNSURE
        return REACHED if passable(self.situation, way.path_xy) else CLOSED

    def _back_off(self) -> Frames:
        """Remember what is in the way and go back a little."""
        self._blocks += 1
        if self._blocks > self.settings.most_blocks:
            raise ScanOver(f"blocked {self._blocks} times: nothing more can be reached")
        self._known.bumped()
        s = self.settings
        for _ in range(round(s.back_off / s.speed / s.tick)):
            yield from self._tick(Velocity(-s.speed))
        self._stop()

    def _retrace(self) -> Frames:
        """Take back what was driven since the last frame that could be placed, until one can be."""
        unplaced, self._unplaced = tuple(self._unplaced), []
        for velocity in reversed(unplaced):
            if self._known.reliable:
                break
            yield from self._tick(Velocity(-velocity.forward, -velocity.turn))
        self._stop()

    def _record(self, view: NextView, outcome: str, way: Route | None = None) -> None:
        """Keep what became of a view; what has no way, or failed twice, is not tried again."""
        path = NO_PATH if way is None else way.path_xy
        self.views.append(ViewRecord(view, outcome, path, self._known.frames))
        if outcome == REACHED:
            self._known.unreachable.clear()
            self._failures = 0
            return
        self._failures += 1
        if outcome not in (BLOCKED, CLOSED) or self._failures >= TRIES:
            self._known.give_up(view)

    def _explained(self, finished: Finished) -> str:
        """Why the planner finished; with the last hindrance where views were left out."""
        if not self._known.unreachable:
            return finished.why
        return f"{finished.why} ({self.views[-1].outcome})"

    def _turn_until(self, content: Callable[[], bool], otherwise: str) -> Frames:
        """Turn on the spot until a frame brings what is wanted; end the scan after a look round."""
        turn, turned = self._follower.max_turn, 0.0
        while not content():
            if turned > LOOK_ROUND * 2 * np.pi:
                raise ScanOver(otherwise)
            yield from self._tick(Velocity(0.0, turn))
            turned += turn * self.settings.tick
        self._stop()

    def _tick(self, velocity: Velocity) -> Frames:
        """Drive for one tick, and take a frame when it is time."""
        seconds, before = self.settings.tick, self.robot.odometry()
        self._went(before)
        self._way.told(velocity.forward)
        self.robot.drive(velocity)
        self.robot.wait(seconds)
        self._known.whereabouts.moved(velocity, seconds)
        after = self.robot.odometry()
        self._went(after)
        step = commanded = abs(velocity.forward) * seconds
        if before is not None and after is not None:
            step = float(np.linalg.norm(after.T_odom_base.xy - before.T_odom_base.xy))
        # What the wheels did not do can not be taken back.
        if step >= commanded / 2:
            self._unplaced.append(velocity)
        if self.robot.now >= self._due - 1e-6:
            yield from self._look()

    def _went(self, odometry: Odometry | None) -> None:
        """Count what was driven until now; the robot goes on while a frame is worked on."""
        now = self.robot.now - self.robot.held
        self._way.went(now, None if odometry is None else odometry.T_odom_base)

    def _stop(self) -> None:
        """Stand still."""
        self._went(self.robot.odometry())
        self._way.told(0.0)
        self.robot.stop()

    def _look(self) -> Frames:
        """Take a frame; once it went through the pipeline, see whether to go on."""
        self._looked = self.robot.now
        self._due = self._looked + self.settings.frame_interval
        self.frame = self.robot.observe()
        if self._known.frames:
            self.plan_milliseconds.append(self.clock.milliseconds.get("plan", 0.0))
        self.clock = StageClock()
        yield self.frame
        if self._known.frames >= self.settings.most_frames:
            raise ScanOver(f"the limit of {self.settings.most_frames} frames is reached")
        self._end_if_enough()

    @timed("plan")
    def _end_if_enough(self) -> None:
        if self._known.in_view and (done := self.planner.enough(self.situation)) is not None:
            raise ScanOver(done.why)

    @timed("plan")
    def heard(self, step: RecognitionStep) -> None:
        """Take what the latest frame led to."""
        if self.frame is not None:
            self._known.heard(step, self.frame)
        # A late frame says nothing of where the robot is.
        if step.outcome != OUT_OF_ORDER:
            self._went(self.robot.odometry())
            self._way.placed(self.T_map_base if self._known.reliable else None)
        if self._known.reliable:
            self._unplaced.clear()


class _Listener:
    """Hands the pipeline's steps to the scan; a `PipelineObserver`."""

    def __init__(self, scan: ObjectScan) -> None:
        self._scan = scan

    def on_step(self, step: RecognitionStep) -> None:
        self._scan.heard(step)

    def on_end(self, result: RecognitionResult) -> None:
        if result.interrupted:
            self._scan.ended = ": ".join(filter(None, (INTERRUPTED, result.end_reason)))
