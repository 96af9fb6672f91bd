"""A robot drives round an object, models it and classifies it (section 3.1)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circumspect.errors import InputError
from circumspect.exploration.end_reason import EndReason, ScanEnded
from circumspect.exploration.frame_driver import FrameDriver, Frames
from circumspect.exploration.progress_watch import ProgressWatch
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.exploration.view_record import ViewOutcome, ViewRecord
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
from circumspect.recognition import (
    PipelineObserver,
    RecognitionPipeline,
    RecognitionResult,
    RecognitionStep,
    run_pipeline,
)
from circumspect.recognition.stage_clock import StageClock, timed
from circumspect.robot import MobileRobot
from circumspect.sensing import RgbdFrame

MAX_ATTEMPTS = 2
"""Attempts at a view to which the path is blocked or obstructed."""
NO_PATH_XY = np.empty((0, 2))


class ObjectScan:
    """The loop of section 3.1: look, track, fuse, classify, plan, drive.

    Attributes:
        robot: The robot.
        pipeline: Tracks, fuses and classifies.
        planner: Chooses views.
        settings: How the robot drives, and when the scan is given up.
        ended: Why the scan ended; None while it runs.
        views: What came of the views so far.
        target: The view that the robot drives to; None before the first.
    """

    def __init__(
        self,
        robot: MobileRobot,
        pipeline: RecognitionPipeline,
        planner: ViewPlanner,
        settings: ScanSettings | None = None,
    ) -> None:
        """Assemble the parts; nothing moves yet.

        Args:
            robot: Stands anywhere.
            pipeline: Tracks, fuses and classifies.
            planner: Chooses views.
            settings: See `ScanSettings`.
        """
        self.robot = robot
        self.pipeline = pipeline
        self.planner = planner
        self.settings = settings or ScanSettings()
        self.ended: str | None = None
        self.views: list[ViewRecord] = []
        self.target: NextView | None = None
        self._driver = FrameDriver(robot, pipeline, planner, self.settings)
        self._state = self._driver.state
        self._blocks = self._failures = 0

    @property
    def frame(self) -> RgbdFrame | None:
        """The latest frame."""
        return self._driver.frame

    @property
    def clock(self) -> StageClock:
        """Times the work between two frames."""
        return self._driver.clock

    @property
    def plan_milliseconds(self) -> list[float]:
        """Time spent on obstacle map, views and paths, one entry a frame [ms]."""
        return self._driver.plan_milliseconds

    @property
    def situation(self) -> Situation:
        """The input of the planner."""
        return self._driver.situation

    @property
    def T_map_base(self) -> PlanarPose:
        """The estimated pose of the robot."""
        return self._state.T_map_base

    @property
    def driven_m(self) -> float:
        """Distance driven so far [m]."""
        return self._driver.driven_m

    @property
    def turned_deg(self) -> float:
        """The part of the way round the object where the robot has been, 0 … 360 [degrees]."""
        return 360 * float(sectors_visited(self.situation).mean())

    def run(self, observers: Sequence[PipelineObserver] = ()) -> RecognitionResult:
        """Scan until there is a reason to end; `ended` is then the reason.

        Whatever ends it, Ctrl-C included, the robot stops, and then the observers get the steps so
        far.

        Args:
            observers: Notified of every step and of the end.
        """
        try:
            return run_pipeline(self.pipeline, self._frames(), (_ScanUpdater(self), *observers))
        finally:
            self.robot.stop()

    @timed("plan")
    def update(self, step: RecognitionStep) -> None:
        """Update pose, obstacle map and distance with the result of the latest frame."""
        self._driver.update(step)

    def _frames(self) -> Frames:
        """The algorithm: each frame is processed before the robot moves on.

        However it ends, the robot stops at once, even if the generator is closed from outside.
        """
        driver, state = self._driver, self._state
        try:
            # Find the object
            yield from driver.look()
            yield from driver.turn_until(lambda: state.in_view, EndReason.NO_OBJECT)
            while True:
                # Where to look from next
                view = self._next_view()

                # How to get there
                view, way = self._path_to(view)
                if isinstance(way, NoWay):
                    self._record(view, ViewOutcome.NO_PATH, way.why)
                    continue

                # Drive there, and take frames meanwhile
                self.target = view
                yield from self._drive(view, way)
                yield from driver.turn_until(lambda: state.reliable, EndReason.LOST)
        except ScanEnded as end:
            self.ended = str(end)
        finally:
            self.robot.stop()

    @timed("plan")
    def _next_view(self) -> NextView:
        """The planner's choice."""
        view = self.planner.next_view(self.situation)
        if isinstance(view, Finished):
            raise ScanEnded(self._explained(view))
        if not isinstance(view, NextView):
            raise InputError(
                f"the view planner {type(self.planner).__name__} returned a "
                f"{type(view).__name__}; a NextView or Finished is needed"
            )
        return view

    @timed("plan")
    def _path_to(self, view: NextView) -> tuple[NextView, Route | NoWay]:
        """The path to a view, or to a similar one, or the reason why there is none."""
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
        """Follow a path and take frames, until the view is reached or the robot is hindered."""
        driver, state = self._driver, self._state
        watch, outcome = ProgressWatch(self.settings.stuck_after), ViewOutcome.REACHED
        frames = state.frames
        while outcome is ViewOutcome.REACHED:
            velocity = driver.follower.velocity(
                self.T_map_base, way.path_xy, view.T_map_base, self.settings.speed
            )
            if velocity is None:
                break
            frame = self.frame
            yield from driver.tick(velocity)
            # Progress is not measured between frames: the wheels may spin there.
            if self.frame is not frame:
                outcome = self._hindrance(way, watch)
        driver.stop()
        if outcome is ViewOutcome.REACHED:
            yield from driver.stand_and_look()
            if state.frames == frames:
                # Without a new frame the planner would choose the same view for ever.
                outcome = ViewOutcome.ALREADY_THERE
            elif not state.in_view:
                outcome = ViewOutcome.NOT_IN_VIEW
        self._record(view, outcome, path_xy=way.path_xy)
        if outcome is ViewOutcome.BLOCKED:
            yield from self._back_off()
        # The commands of a blocked robot are not retraced: nothing is known of what is behind it.
        elif outcome is ViewOutcome.UNRELIABLE_POSE or state.doubted_for:
            yield from driver.retrace()

    @timed("plan")
    def _hindrance(self, way: Route, watch: ProgressWatch) -> ViewOutcome:
        """What keeps the robot from driving on; `REACHED` if nothing does."""
        if watch.stuck(self.robot.now - self.robot.held, self.T_map_base):
            return ViewOutcome.BLOCKED
        state, settings = self._state, self.settings
        if state.doubted_for > settings.unsure_after or state.blind_for > settings.blind_after:
            return ViewOutcome.UNRELIABLE_POSE
        if not passable(self.situation, way.path_xy):
            return ViewOutcome.OBSTRUCTED
        return ViewOutcome.REACHED

    def _back_off(self) -> Frames:
        """Add an obstacle in front of the robot, and drive back a little."""
        self._blocks += 1
        if self._blocks > self.settings.most_blocks:
            raise ScanEnded(f"blocked {self._blocks} times: nothing more can be reached")
        self._state.add_bump()
        yield from self._driver.back_off()

    def _record(
        self,
        view: NextView,
        outcome: ViewOutcome,
        reason: str | None = None,
        path_xy: np.ndarray = NO_PATH_XY,
    ) -> None:
        """Record what came of a view; give it up if it has no path, or failed twice."""
        reason = outcome.value if reason is None else reason
        self.views.append(ViewRecord(view, outcome, reason, path_xy, self._state.frames))
        if outcome is ViewOutcome.REACHED:
            self._state.unreachable.clear()
            self._failures = 0
            return
        self._failures += 1
        can_retry = outcome in (ViewOutcome.BLOCKED, ViewOutcome.OBSTRUCTED)
        if not can_retry or self._failures >= MAX_ATTEMPTS:
            self._state.give_up(view)

    def _explained(self, finished: Finished) -> str:
        """Why the planner finished; with the last hindrance if views were left out."""
        if not self._state.unreachable:
            return finished.why
        return f"{finished.why} ({self.views[-1].reason})"


class _ScanUpdater:
    """Passes the pipeline's steps to the scan; a `PipelineObserver`."""

    def __init__(self, scan: ObjectScan) -> None:
        self._scan = scan

    def on_step(self, step: RecognitionStep) -> None:
        self._scan.update(step)

    def on_end(self, result: RecognitionResult) -> None:
        if result.interrupted:
            parts = (EndReason.INTERRUPTED, result.end_reason)
            self._scan.ended = ": ".join(filter(None, parts))
