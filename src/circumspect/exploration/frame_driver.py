"""Drives the robot, takes frames at fixed intervals and measures the distance."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import TypeAlias

import numpy as np

from circumspect.exploration.end_reason import ScanEnded
from circumspect.exploration.exploration_state import ExplorationState
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.geometry import PlanarPose
from circumspect.planning import PlannerInput, ViewPlanner
from circumspect.recognition import FrameOutcome, RecognitionPipeline, RecognitionStep
from circumspect.recognition.stage_clock import StageClock, timed
from circumspect.robot import MobileRobot, PathFollower, Velocity
from circumspect.sensing import Odometry, RgbdFrame

MAX_EXTRA_FRAMES = 2
"""Maximum number of further frames at a view that does not show the object."""
LOOK_ROUND_TURNS = 1.1
"""Rotation in a look round [turns]."""
Frames: TypeAlias = Generator[RgbdFrame, None, None]
"""Frames that are processed before the robot moves on."""
MAX_COMMANDED_RATIO = 2.0
"""A step longer than this many times the commanded one is an odometry jump or a pose correction."""


class DistanceMeter:
    """Sums up the distances between the reliable poses of frames.

    Between two frames, and without reliable poses, the distance is measured by odometry. Over a
    segment without reliable poses it is at least the distance between its ends, because wheels may
    be stuck.
    """

    def __init__(self) -> None:
        """Start at 0 m."""
        self._until_frame = self._wheels = self._commanded = self._speed = 0.0
        self._now: float | None = None
        self._T_odom_base: PlanarPose | None = None
        self._T_map_base: PlanarPose | None = None
        self._is_unreliable = False

    @property
    def metres(self) -> float:
        """The distance so far [m]."""
        return self._until_frame + self._wheels

    def set_speed(self, speed: float) -> None:
        """Set the commanded speed since the last `add_odometry` [m/s]."""
        self._speed = abs(speed)

    def add_odometry(self, now: float, T_odom_base: PlanarPose | None) -> None:
        """Add the distance since the last call.

        Args:
            now: Time without the pauses of the operator [s].
            T_odom_base: Pose by wheel odometry; None if there is none.
        """
        commanded = 0.0 if self._now is None else self._speed * (now - self._now)
        wheels, before = commanded, self._T_odom_base
        if before is not None and T_odom_base is not None:
            wheels = min(
                float(np.linalg.norm(T_odom_base.xy - before.xy)), MAX_COMMANDED_RATIO * commanded
            )
        self._commanded += commanded
        self._wheels += wheels
        self._now, self._T_odom_base = now, T_odom_base

    def add_pose(self, T_map_base: PlanarPose | None) -> None:
        """Add the pose of a frame.

        Args:
            T_map_base: Pose of the base; None if it is not reliable.
        """
        if T_map_base is None:
            self._is_unreliable = True
            return
        self._until_frame += self._step(T_map_base)
        self._wheels = self._commanded = 0.0
        self._T_map_base, self._is_unreliable = T_map_base, False

    def _step(self, T_map_base: PlanarPose) -> float:
        """Distance from the last reliable pose to this one [m]."""
        if self._T_map_base is None:
            return self._wheels
        away = float(np.linalg.norm(T_map_base.xy - self._T_map_base.xy))
        chord = min(away, MAX_COMMANDED_RATIO * self._commanded)
        # The path between the two poses is unknown.
        return max(chord, self._wheels) if self._is_unreliable else chord


class FrameDriver:
    """Executes motions in ticks; each motion yields the frames that become due.

    Attributes:
        robot: The robot.
        settings: Speed and intervals.
        state: Pose and map, updated with each frame.
        follower: Follows paths.
        frame: The latest frame.
        clock: Times the work between two frames.
        plan_milliseconds: Time spent on planning, one entry a frame [ms].
    """

    def __init__(
        self,
        robot: MobileRobot,
        pipeline: RecognitionPipeline,
        planner: ViewPlanner,
        settings: ScanSettings,
    ) -> None:
        """Start at the current pose of the robot.

        Args:
            robot: The robot, at any pose.
            pipeline: Models the object.
            planner: Decides after each frame whether the scan is complete.
            settings: Speed and intervals.
        """
        self.robot = robot
        self.settings = settings
        self.state = ExplorationState(robot)
        self.follower = PathFollower(max_turn=min(robot.max_turn, settings.max_turn))
        self.frame: RgbdFrame | None = None
        self.clock = StageClock()
        self.plan_milliseconds: list[float] = []
        self._pipeline, self._planner = pipeline, planner
        self._meter = DistanceMeter()
        self._unconfirmed: list[Velocity] = []
        """Commands since the last reliable pose."""
        self._looked_at = self._due_at = robot.now

    @property
    def planner_input(self) -> PlannerInput:
        """The input of the planner."""
        return self.state.planner_input(self._pipeline.model)

    @property
    def driven_m(self) -> float:
        """Distance driven so far [m]."""
        return self._meter.metres

    def tick(self, velocity: Velocity) -> Frames:
        """Drive for one tick, and take a frame if one is due."""
        seconds, before = self.settings.tick, self.robot.odometry()
        self._measure(before)
        self._meter.set_speed(velocity.forward)
        self.robot.drive(velocity)
        self.robot.wait(seconds)
        self.state.pose_tracker.add_command(velocity, seconds)
        after = self.robot.odometry()
        self._measure(after)
        step = commanded = abs(velocity.forward) * seconds
        if before is not None and after is not None:
            step = float(np.linalg.norm(after.T_odom_base.xy - before.T_odom_base.xy))
        # Commands that the wheels did not execute are not retraced.
        if step >= commanded / 2:
            self._unconfirmed.append(velocity)
        if self.robot.now >= self._due_at - 1e-6:
            yield from self.look()

    def stop(self) -> None:
        """Stand still."""
        self._measure(self.robot.odometry())
        self._meter.set_speed(0.0)
        self.robot.stop()

    def look(self) -> Frames:
        """Take a frame; end the scan if it is complete after processing."""
        self._looked_at = self.robot.now
        self._due_at = self._looked_at + self.settings.frame_interval
        self.frame = self.robot.observe()
        if self.state.frames:
            self.plan_milliseconds.append(self.clock.milliseconds.get("plan", 0.0))
        self.clock = StageClock()
        yield self.frame
        if self.state.frames >= self.settings.max_frames:
            raise ScanEnded(f"the limit of {self.settings.max_frames} frames is reached")
        self._end_if_complete()

    def stand_and_look(self) -> Frames:
        """Take a frame without moving; take more if it is late or does not show the object."""
        if self.robot.now > self._looked_at:
            yield from self.look()
        for _ in range(MAX_EXTRA_FRAMES):
            if self.state.in_view:
                return
            self.robot.wait(self.settings.frame_interval)
            yield from self.look()

    def turn_until(self, is_done: Callable[[], bool], otherwise: str) -> Frames:
        """Turn on the spot until a condition holds; end the scan after a look round."""
        turn, turned = self.follower.max_turn, 0.0
        while not is_done():
            if turned > LOOK_ROUND_TURNS * 2 * np.pi:
                raise ScanEnded(otherwise)
            yield from self.tick(Velocity(0.0, turn))
            turned += turn * self.settings.tick
        self.stop()

    def back_off(self) -> Frames:
        """Drive backwards by the distance of the settings."""
        s = self.settings
        for _ in range(round(s.back_off / s.speed / s.tick)):
            yield from self.tick(Velocity(-s.speed))
        self.stop()

    def retrace(self) -> Frames:
        """Undo the commands since the last reliable pose, until a pose is reliable."""
        unconfirmed, self._unconfirmed = tuple(self._unconfirmed), []
        for velocity in reversed(unconfirmed):
            if self.state.reliable:
                break
            yield from self.tick(Velocity(-velocity.forward, -velocity.turn))
        self.stop()

    def update(self, step: RecognitionStep) -> None:
        """Update state and distance with the result of the latest frame."""
        if self.frame is not None:
            self.state.update(step, self.frame)
        # A late frame does not show where the robot is.
        if step.outcome is not FrameOutcome.OUT_OF_ORDER:
            self._measure(self.robot.odometry())
            self._meter.add_pose(self.state.T_map_base if self.state.reliable else None)
        if self.state.reliable:
            self._unconfirmed.clear()

    @timed("plan")
    def _end_if_complete(self) -> None:
        if (
            self.state.in_view
            and (end := self._planner.check_finished(self.planner_input)) is not None
        ):
            raise ScanEnded(end.reason)

    def _measure(self, odometry: Odometry | None) -> None:
        """Measure the distance so far; the robot moves on while a frame is processed."""
        now = self.robot.now - self.robot.paused_seconds
        self._meter.add_odometry(now, None if odometry is None else odometry.T_odom_base)
