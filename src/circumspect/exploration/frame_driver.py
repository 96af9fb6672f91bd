"""Drives the robot and takes frames at fixed intervals."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import TypeAlias

import numpy as np

from circumspect.exploration.distance_meter import DistanceMeter
from circumspect.exploration.end_reason import ScanEnded
from circumspect.exploration.exploration_state import ExplorationState
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.planning import Situation, ViewPlanner
from circumspect.recognition import FrameOutcome, RecognitionPipeline, RecognitionStep
from circumspect.recognition.stage_clock import StageClock, timed
from circumspect.robot import MobileRobot, PathFollower, Velocity
from circumspect.sensing import Odometry, RgbdFrame

MAX_EXTRA_FRAMES = 2
"""Further frames that are taken from a view that does not show the object."""
LOOK_ROUND_TURNS = 1.1
"""Length of a look round [turns]."""

Frames: TypeAlias = Generator[RgbdFrame, None, None]
"""Frames that are processed before the robot moves on."""


class FrameDriver:
    """Executes motions in ticks; each motion yields the frames that are due meanwhile.

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
        """Start where the robot stands.

        Args:
            robot: Stands anywhere.
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
    def situation(self) -> Situation:
        """The input of the planner."""
        return self.state.situation(self._pipeline.model)

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
        """Take a frame; after it was processed, end the scan if it is complete."""
        self._looked_at = self.robot.now
        self._due_at = self._looked_at + self.settings.frame_interval
        self.frame = self.robot.observe()
        if self.state.frames:
            self.plan_milliseconds.append(self.clock.milliseconds.get("plan", 0.0))
        self.clock = StageClock()
        yield self.frame
        if self.state.frames >= self.settings.most_frames:
            raise ScanEnded(f"the limit of {self.settings.most_frames} frames is reached")
        self._end_if_complete()

    def stand_and_look(self) -> Frames:
        """Take a frame from here; a few if the first ones come late or do not show the object."""
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
        """Drive backwards a little."""
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
        if self.state.in_view and (end := self._planner.enough(self.situation)) is not None:
            raise ScanEnded(end.why)

    def _measure(self, odometry: Odometry | None) -> None:
        """Measure the distance until now; the robot moves on while a frame is processed."""
        now = self.robot.now - self.robot.held
        self._meter.add_odometry(now, None if odometry is None else odometry.T_odom_base)
