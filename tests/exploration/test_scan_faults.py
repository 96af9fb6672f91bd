"""Scans with registered poses on robots with faults."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scan_world import NOTHING, QUICK, scan, wall

from circumspect.furniture import make_furniture
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.recognition import FrameOutcome, RecognitionResult, RecognitionStep
from circumspect.runs import RunFolder
from circumspect.sensing import DepthNoise
from circumspect.simulation import (
    Blackout,
    Blocked,
    ClockStartingAt,
    DroppedFrames,
    EqualStamps,
    Kidnapped,
    NanFrame,
    OdometryCovariance,
    OdometryGone,
    OdometryJumping,
    OdometryLagging,
    OdometryOfAnotherEpoch,
    OdometryStuck,
    SimulatedRobot,
    Surface,
    UnorderedFrames,
    WrongUnit,
)
from circumspect.tracking import KnownPoses, PoseEstimator, Tracker, TrackingSettings
from circumspect.tracking.odometry_check import CONTRADICTED, DIFFERENT_CLOCKS

CAMERA = PinholeCamera(320, 240, 285.0, 285.0, 159.5, 119.5)
CHAIR = make_furniture("chair", 3)
AFTER = 6.0
"""When a fault begins [s]: a sixth of the way round."""


def room(west: float, east: float) -> tuple[Surface, ...]:
    return (
        wall((west, 2.3), (east, 2.4)), wall((west, -2.4), (east, -2.3)),
        wall((east - 0.1, -2.4), (east, 2.4)), wall((west, -2.4), (west + 0.1, 2.4)),
    )  # fmt: skip


ROOM, LONG_ROOM = room(-2.6, 2.2), room(-3.0, 3.0)
FAULTS = {
    "none": lambda robot: robot,
    "blackout": lambda robot: Blackout(robot, AFTER),
    "frames dropped": lambda robot: DroppedFrames(robot, 0.3),
    "frames late": lambda robot: UnorderedFrames(robot, 0.2),
    "stamps twice": lambda robot: EqualStamps(robot, 0.2),
    "NaN frame": lambda robot: NanFrame(robot, 5),
    "millimetres from then on": lambda robot: WrongUnit(robot, AFTER),
    "millimetres": lambda robot: WrongUnit(robot),
    "never any odometry": lambda robot: OdometryGone(robot),
    "odometry gone": lambda robot: OdometryGone(robot, AFTER),
    "odometry jumping": lambda robot: OdometryJumping(robot, AFTER),
    "odometry stuck": lambda robot: OdometryStuck(robot, AFTER),
    "blocked": lambda robot: Blocked(robot, AFTER, 5.0),
    "kidnapped": lambda robot: Kidnapped(robot, AFTER, PlanarPose(0.3, -0.1, 0.35)),
    "clock from zero": lambda robot: ClockStartingAt(robot, 0.0),
    "clock from 1970": lambda robot: ClockStartingAt(robot, 1.7e9),
    "NaN covariance": lambda robot: OdometryCovariance(robot, np.nan),
    "constant covariance": lambda robot: OdometryCovariance(robot, 0.1),
    "images 0.5 s behind": lambda robot: OdometryLagging(robot, 0.5),
    "images 1 s behind": lambda robot: OdometryLagging(robot, 1.0),
    "another epoch": lambda robot: OdometryOfAnotherEpoch(robot),
}

OTHER_CLOCKS = ("images 0.5 s behind", "images 1 s behind", "another epoch")
WRONG_ODOMETRY = ("odometry stuck", "blocked")
"""Most motions contradict it."""
ENDS = {
    "millimetres from then on": "lost: no pose has been reliable for too long",
    "millimetres": "no object in view after a look round",
}


class Trusted:
    """Errors of reliable and of accurate poses, from the first one on [m]."""

    def __init__(self, robot: SimulatedRobot) -> None:
        self.robot = robot
        self.first = None
        self.off: list[float] = []
        self.accurate_off: list[float] = []

    def on_step(self, step: RecognitionStep) -> None:
        if step.pose is None:
            return
        truth = self.robot.truth().T_map_camera
        if self.first is None:
            self.first = truth * step.pose.T_map_camera.inv()
        found = self.first * step.pose.T_map_camera
        away = float(np.linalg.norm(found.translation - truth.translation))
        if step.pose.reliable:
            self.off.append(away)
        if step.pose.accurate:
            self.accurate_off.append(away)

    def on_end(self, result) -> None:
        pass


def in_an_empty_room(
    poses: PoseEstimator, path: Path, walls: tuple[Surface, ...] = ROOM
) -> RecognitionResult:
    object_scan = scan(
        mesh=NOTHING, others=walls, poses=poses, camera=CAMERA,
        settings=replace(QUICK, max_frames=150),
    )  # fmt: skip
    result = object_scan.run((RunFolder(path, {}),))
    assert object_scan.ended
    return result


SETTINGS = TrackingSettings.for_noise(DepthNoise(systematic_disparity=0.0))
"""Of the simulated camera, whose depth is not distorted."""


@pytest.mark.parametrize("walls", [ROOM, LONG_ROOM])
def test_walls_of_an_empty_room_are_not_classified(
    walls: tuple[Surface, ...], tmp_path: Path
) -> None:
    result = in_an_empty_room(KnownPoses(), tmp_path, walls)
    assert result.prediction is None
    assert json.loads((tmp_path / "result.json").read_text())["label"] is None
    # What looks like an object from afar, a corner, turns out to be the room.
    outcomes = {step.outcome for step in result.steps}
    assert outcomes == {FrameOutcome.NO_OBJECT} or FrameOutcome.TOO_WIDE in outcomes


def test_a_lost_camera_in_an_empty_room_gives_no_answer(tmp_path: Path) -> None:
    result = in_an_empty_room(Tracker(), tmp_path)
    assert FrameOutcome.NO_POSE in {step.outcome for step in result.steps}
    document = json.loads((tmp_path / "result.json").read_text())
    assert (document["label"], document["confident"]) == (None, False)


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_keep_poses_accurate_and_the_run_saved(fault: str, tmp_path: Path) -> None:
    object_scan = scan(
        fault=FAULTS[fault], mesh=CHAIR, others=ROOM, poses=Tracker(settings=SETTINGS), camera=CAMERA,
        settings=replace(QUICK, speed=0.1, frame_interval=0.5, max_frames=60),
    )  # fmt: skip
    trusted = Trusted(object_scan.robot.simulated)
    result = object_scan.run((trusted, RunFolder(tmp_path, {})))
    assert object_scan.ended.startswith(ENDS.get(fault, "the limit of 60 frames is reached"))
    assert max(trusted.off, default=0.0) < 0.05
    assert max(trusted.accurate_off, default=0.0) < 0.03
    assert bool(trusted.accurate_off) == (fault != "millimetres")
    warned = [step.index for step in result.steps if step.odometry_warning]
    assert bool(warned) == (fault in (*OTHER_CLOCKS, *WRONG_ODOMETRY))
    reason = CONTRADICTED if fault in WRONG_ODOMETRY else DIFFERENT_CLOCKS
    assert all(result.steps[index].odometry_warning.startswith(reason) for index in warned)
    if fault in OTHER_CLOCKS:
        # The robot moves from the first frame on.
        assert warned == list(range(warned[0], 60))
        assert warned[0] <= 20
        assert not any(step.pose.source == "odometry" for step in result.steps[warned[0] :])
    document = json.loads((tmp_path / "result.json").read_text())
    assert document["frames"] == len(result.steps)
    # An answer from the first side alone is not confident.
    assert not (document["confident"] and fault in ENDS)
    # The classifier of this test names a class by the occupied share of the grid.
    assert (document["label"] is None) == (fault == "millimetres")
    assert (tmp_path / "model.ply").exists() == (fault != "millimetres")
