"""The scan of an object by a robot that drives round it (section 3.1)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circumspect.errors import InputError
from circumspect.exploration.end_reason import EndReason, ProgressWatch, ScanEnded
from circumspect.exploration.frame_driver import FrameDriver, Frames
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.exploration.view_record import ViewOutcome, ViewRecord
from circumspect.geometry import PlanarPose
from circumspect.planning import (
    Finished,
    NextView,
    NoPath,
    PlannerInput,
    Route,
    ViewPlanner,
    alternatives,
    is_free,
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
"""Maximum number of attempts at a view with a blocked or obstructed path."""
NO_PATH_XY = np.empty((0, 2))


class ObjectScan:
    """The scan loop of section 3.1: look, track, fuse, classify, plan, drive.

    Attributes:
        robot: The robot.
        pipeline: Tracks, fuses and classifies.
        planner: Chooses views.
        settings: Settings of the scan.
        ended: Why the scan ended; None while it runs.
        views: Outcomes of the views so far.
        target: The view that the robot drives to; None before the first.
    """

    def __init__(
        self,
        robot: MobileRobot,
        pipeline: RecognitionPipeline,
        planner: ViewPlanner,
        settings: ScanSettings | None = None,
    ) -> None:
        """Set the parts; the robot does not move yet.

        Args:
            robot: The robot, at any pose.
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
    def planner_input(self) -> PlannerInput:
        """The input of the planner."""
        return self._driver.planner_input

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
        """Total azimuth around the object where the robot has been, 0 … 360 [degrees]."""
        return 360 * float(sectors_visited(self.planner_input).mean())

    def run(self, observers: Sequence[PipelineObserver] = ()) -> RecognitionResult:
        """Scan until there is a reason to end, then store it in `ended`.

        The robot always stops at the end, even after Ctrl-C; then the observers get the steps so
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
        """The scan algorithm: each frame is processed before the robot moves on.

        The robot stops at the end, even if the generator is closed from outside.
        """
        driver, state = self._driver, self._state
        try:
            # Find the object
            yield from driver.look()
            yield from driver.turn_until(lambda: state.in_view, EndReason.NO_OBJECT)
            while True:
                # Choose the next view
                view = self._next_view()

                # Plan a path to it
                view, path = self._path_to(view)
                if isinstance(path, NoPath):
                    self._record(view, ViewOutcome.NO_PATH, path.reason)
                    continue

                # Drive there and take frames
                self.target = view
                yield from self._drive(view, path)
                yield from driver.turn_until(lambda: state.reliable, EndReason.LOST)
        except ScanEnded as end:
            self.ended = str(end)
        finally:
            self.robot.stop()

    @timed("plan")
    def _next_view(self) -> NextView:
        """The planner's choice."""
        view = self.planner.next_view(self.planner_input)
        if isinstance(view, Finished):
            raise ScanEnded(self._finish_reason(view))
        if not isinstance(view, NextView):
            raise InputError(
                f"the view planner {type(self.planner).__name__} returned a "
                f"{type(view).__name__}; a NextView or Finished is needed"
            )
        return view

    @timed("plan")
    def _path_to(self, view: NextView) -> tuple[NextView, Route | NoPath]:
        """A path to the view or to a similar one, or the reason why there is none."""
        planner_input = self.planner_input
        first = path = route(planner_input, view.T_map_base, self.settings.keep)
        if isinstance(first, Route):
            return view, first
        for other in alternatives(view, self.robot.T_base_camera):
            path = route(planner_input, other.T_map_base, self.settings.keep)
            if isinstance(path, Route):
                return other, path
        return view, first

    def _drive(self, view: NextView, path: Route) -> Frames:
        """Follow a path and take frames, until the view is reached or the robot is hindered."""
        driver, state = self._driver, self._state
        watch, outcome = ProgressWatch(self.settings.stuck_after), ViewOutcome.REACHED
        frames = state.frames
        while outcome is ViewOutcome.REACHED:
            velocity = driver.follower.velocity(
                self.T_map_base, path.path_xy, view.T_map_base, self.settings.speed
            )
            if velocity is None:
                break
            frame = self.frame
            yield from driver.tick(velocity)
            # Progress is not measured between frames: the wheels may spin there.
            if self.frame is not frame:
                outcome = self._driving_outcome(path, watch)
        driver.stop()
        if outcome is ViewOutcome.REACHED:
            yield from driver.stand_and_look()
            if state.frames == frames:
                # Without a new frame the planner would choose the same view again.
                outcome = ViewOutcome.ALREADY_THERE
            elif not state.in_view:
                outcome = ViewOutcome.NOT_IN_VIEW
        self._record(view, outcome, path_xy=path.path_xy)
        if outcome is ViewOutcome.BLOCKED:
            yield from self._back_off()
        # A blocked robot does not retrace its commands: the space behind it is unknown.
        elif outcome is ViewOutcome.UNRELIABLE_POSE or state.doubted_for:
            yield from driver.retrace()

    @timed("plan")
    def _driving_outcome(self, path: Route, watch: ProgressWatch) -> ViewOutcome:
        """The outcome that stops the robot; `REACHED` if it can drive on."""
        state, settings = self._state, self.settings
        now = self.robot.now - self.robot.paused_seconds
        if state.motion_is_known and watch.update(now, self.T_map_base):
            return ViewOutcome.BLOCKED
        if state.doubted_for > settings.unsure_after or state.blind_for > settings.blind_after:
            return ViewOutcome.UNRELIABLE_POSE
        if not is_free(self.planner_input, path.path_xy):
            return ViewOutcome.OBSTRUCTED
        return ViewOutcome.REACHED

    def _back_off(self) -> Frames:
        """Add an obstacle in front of the robot, and drive backwards."""
        self._blocks += 1
        if self._blocks > self.settings.max_blocks:
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
        """Record the outcome of a view; give it up if it has no path, or failed twice."""
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

    def _finish_reason(self, finished: Finished) -> str:
        """Why the planner finished, with the last failure if views were left out."""
        if not self._state.unreachable:
            return finished.reason
        return f"{finished.reason} ({self.views[-1].reason})"


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
