"""The loop of a scan on a simulated robot: rounds, end reasons and faults."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scan_world import NOTHING, QUICK, scan, start, wall
from small_world import StepRecorder
from volume_classifier import VolumeClassifier

from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.errors import InputError, OutputError
from circumspect.exploration.end_reason import EndReason
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.exploration.view_record import ViewOutcome
from circumspect.geometry import PlanarPose
from circumspect.planning import CirclePlanner, ConfidencePlanner, SurfaceNormalPlanner
from circumspect.planning.circle_planner import ALL_TRIED
from circumspect.planning.view_planner import AS_FAR_AS_POSSIBLE, ROUND_COMPLETE
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.runs import RunFolder
from circumspect.runs.run_path_log import RunPathLog
from circumspect.runs.scan_file import ScanFile
from circumspect.sensing import RgbdFrame
from circumspect.simulation import SimulatedRobot, block
from circumspect.simulation.camera_faults import Blackout, DroppedFrames, UnorderedFrames
from circumspect.simulation.robot_faults import Blocked, OdometryGone, OdometryStuck
from circumspect.tracking import KnownPoses, PoseEstimate, TrackingState


@pytest.mark.parametrize("planner", [SurfaceNormalPlanner(), CirclePlanner()])
def test_a_scan_round_a_box_is_complete_and_saved(planner, tmp_path: Path) -> None:
    object_scan = scan(planner=planner)
    folder = RunFolder(tmp_path, {"command": "test"})
    log, file = RunPathLog(object_scan, folder), ScanFile(object_scan, tmp_path / "scan.json")
    result = object_scan.run((log, file, folder))
    assert object_scan.ended == ROUND_COMPLETE
    assert result.prediction is not None
    assert result.last.coverage == 1.0
    assert all(record.outcome == ViewOutcome.REACHED for record in object_scan.views)
    # No shorter than the circle that just clears the box, no longer than twice the wanted one.
    assert 2 * np.pi * 0.6 < object_scan.driven_m < 2 * 2 * np.pi * 1.3
    document = json.loads((tmp_path / "scan.json").read_text())
    assert document["ended"] == ROUND_COMPLETE
    assert len(document["views"]) == len(object_scan.views) >= 5
    assert document["turned_deg"] > 330
    assert len((tmp_path / "log.jsonl").read_text().splitlines()) == len(result.steps)
    assert (tmp_path / "picture.png").exists()


def test_a_planner_that_returns_another_type_is_named() -> None:
    class Odd(CirclePlanner):
        def next_view(self, planner_input):
            return None

    object_scan = scan(planner=Odd())
    with pytest.raises(InputError, match="planner Odd returned a NoneType; a NextView or Finished"):
        object_scan.run()


def test_the_robot_never_touches_the_object() -> None:
    object_scan = scan(planner=SurfaceNormalPlanner())
    wait, places = object_scan.robot.wait, []

    def waited(seconds: float) -> None:
        wait(seconds)
        places.append(object_scan.robot.simulated.truth().T_map_base.translation[:2])

    object_scan.robot.wait = waited
    object_scan.run()
    beyond = np.maximum(np.abs(places) - [0.25, 0.2], 0)
    assert np.hypot(*beyond.T).min() > object_scan.robot.radius


def test_the_same_seed_gives_the_same_scan() -> None:
    results = []
    for _ in range(2):
        object_scan = scan(seed=4, settings=replace(QUICK, max_frames=12))
        result = object_scan.run()
        results.append((object_scan.driven_m, result.last.prediction, len(result.last.model.sums)))
    assert results[0] == results[1]


def test_a_robot_that_faces_away_searches_for_the_object() -> None:
    object_scan = scan(pose=start(askew=2.5), settings=replace(QUICK, max_frames=30))
    result = object_scan.run()
    outcomes = [step.outcome for step in result.steps]
    assert outcomes[0] == "no object in view"
    assert "classified" in outcomes
    assert object_scan.ended == "the limit of 30 frames is reached"


def test_without_an_object_the_scan_ends_after_one_turn(tmp_path: Path) -> None:
    object_scan = scan(mesh=NOTHING)
    result = object_scan.run(
        (RunFolder(tmp_path, {}), ScanFile(object_scan, tmp_path / "scan.json"))
    )
    assert object_scan.ended == "no object in view after a look round"
    assert 24 <= len(result.steps) <= 32
    assert result.points_xyz.shape == (0, 3)
    assert object_scan.views == []
    assert json.loads((tmp_path / "result.json").read_text())["label"] is None
    assert json.loads((tmp_path / "scan.json").read_text())["ended"] == object_scan.ended


def test_an_object_larger_than_the_room_ends_the_scan_without_a_confident_answer(
    tmp_path: Path,
) -> None:
    bar = block((-0.2, -2.4, 0.0), (0.2, 2.4, 0.7))
    walls = (
        wall((-2.6, 2.4), (2.6, 2.5)), wall((-2.6, -2.5), (2.6, -2.4)),
        wall((2.4, -2.5), (2.5, 2.5)), wall((-2.5, -2.5), (-2.4, 2.5)),
    )  # fmt: skip
    object_scan = scan(mesh=bar, others=walls, pose=PlanarPose(1.5, -0.3, np.pi / 2))
    result = object_scan.run(
        (RunFolder(tmp_path, {}), ScanFile(object_scan, tmp_path / "scan.json"))
    )
    document = json.loads((tmp_path / "result.json").read_text())
    assert (document["frames"], document["confident"]) == (len(result.steps), False)
    assert json.loads((tmp_path / "scan.json").read_text())["ended"] == object_scan.ended
    assert (tmp_path / "trajectory.txt").exists()
    assert object_scan.ended.startswith((ALL_TRIED, AS_FAR_AS_POSSIBLE, "blocked 3 times"))
    assert len(result.steps) < 200
    assert result.last.coverage < 0.8


def test_views_behind_a_wall_are_missed_and_the_others_reached() -> None:
    behind = wall((-1.0, -2.0), (-0.9, 2.0))
    object_scan = scan(others=(behind,), planner=CirclePlanner(), pose=start(-60))
    object_scan.run()
    assert object_scan.ended.startswith((ALL_TRIED, AS_FAR_AS_POSSIBLE))
    missed = [record for record in object_scan.views if record.outcome != ViewOutcome.REACHED]
    assert missed
    assert sum(record.outcome == ViewOutcome.REACHED for record in object_scan.views) >= 4


def test_a_blocked_robot_ends_the_scan_with_its_answer(tmp_path: Path) -> None:
    object_scan = scan(fault=lambda robot: Blocked(robot, after=6.0, seconds=1e6))
    result = object_scan.run((RunFolder(tmp_path, {}),))
    assert object_scan.ended == "blocked 3 times: nothing more can be reached"
    assert ViewOutcome.BLOCKED in {record.outcome for record in object_scan.views}
    assert result.prediction is not None
    assert (tmp_path / "model.ply").exists()


@pytest.mark.parametrize(
    "fault",
    [
        lambda robot: Blocked(robot, after=8.0, seconds=5.0),
        lambda robot: Blackout(robot, after=8.0, seconds=5.0),
        lambda robot: DroppedFrames(robot, 0.3),
        lambda robot: UnorderedFrames(robot, 0.2),
        lambda robot: OdometryGone(robot, after=8.0),
        lambda robot: OdometryGone(robot),
        lambda robot: OdometryStuck(robot, after=8.0),
    ],
    ids=[
        "blocked",
        "blackout",
        "dropped",
        "unordered",
        "odometry gone",
        "never any odometry",
        "odometry stuck",
    ],
)
def test_the_round_is_completed_despite_the_fault(fault) -> None:
    object_scan = scan(fault=fault)
    object_scan.run()
    assert object_scan.ended == ROUND_COMPLETE


class Doubtful(KnownPoses):
    """Tracking is lost from one frame on."""

    def __init__(self, after: int, until: int = 10**6) -> None:
        self.count, self.after, self.until = 0, after, until

    def track(self, frame: RgbdFrame) -> PoseEstimate:
        self.count += 1
        known = super().track(frame)
        if not self.after <= self.count < self.until:
            return known
        return replace(known, state=TrackingState.LOST, reason="the scans contradict the map")


def test_a_lost_robot_ends_the_scan_as_lost() -> None:
    object_scan = scan(poses=Doubtful(after=8))
    result = object_scan.run()
    assert object_scan.ended == EndReason.LOST
    assert len(result.steps) < 60
    assert result.steps[-1].prediction == result.steps[6].prediction


class Unverified(KnownPoses):
    """Some frames are dead-reckoned; their pose may or may not be unverified."""

    def __init__(self, unverified: bool) -> None:
        self.count, self.unverified = 0, unverified

    def track(self, frame: RgbdFrame) -> PoseEstimate:
        self.count += 1
        known = super().track(frame)
        if not 17 <= self.count < 25:
            return known
        state = TrackingState.DEAD_RECKONING
        return replace(known, state=state, reason="unknown", unverified=self.unverified)


@pytest.mark.parametrize("unverified", [True, False])
def test_a_dead_reckoned_robot_drives_on_while_its_pose_is_unverified(unverified: bool) -> None:
    slow = replace(QUICK, speed=0.05, doubt_after=5.0)
    object_scan = scan(poses=Unverified(unverified), settings=slow)
    object_scan.run()
    outcomes = {record.outcome for record in object_scan.views}
    assert (ViewOutcome.UNRELIABLE_POSE not in outcomes) == unverified


class Frozen(Doubtful):
    """A lost tracker without odometry: its pose stays as it is."""

    def track(self, frame: RgbdFrame) -> PoseEstimate:
        known = super().track(frame)
        if known.state is not TrackingState.LOST:
            self.pose = known.T_map_camera
        return known.at(self.pose)


def test_a_lost_pose_is_not_taken_for_a_blocked_robot() -> None:
    object_scan = scan(poses=Frozen(after=8, until=24), fault=lambda robot: OdometryGone(robot))
    object_scan.run()
    assert ViewOutcome.BLOCKED not in {record.outcome for record in object_scan.views}


class TruePlaces:
    """True position of the robot at each frame."""

    def __init__(self, robot: SimulatedRobot) -> None:
        self.robot, self.places_xy = robot, []

    def on_step(self, step: RecognitionStep) -> None:
        self.places_xy.append(self.robot.truth().T_map_base.translation[:2])

    def on_end(self, result: RecognitionResult) -> None:
        pass


@pytest.mark.parametrize("fault", [None, lambda robot: OdometryGone(robot)])
def test_a_lost_robot_returns_to_its_last_reliable_pose(fault) -> None:
    object_scan = scan(poses=Doubtful(after=8), fault=fault)
    true = TruePlaces(object_scan.robot.simulated)
    object_scan.run((true,))
    assert object_scan.ended == EndReason.LOST
    places = np.array(true.places_xy)
    off = np.linalg.norm(places - places[6], axis=1)
    assert off.max() > 0.5
    assert off[-1] < 0.1


def test_a_blocked_and_lost_robot_does_not_drive_back() -> None:
    """The space behind the robot is unknown."""
    object_scan = scan(poses=Doubtful(after=9), fault=lambda robot: Blocked(robot, 6.0, 6.0))
    true = TruePlaces(object_scan.robot.simulated)
    object_scan.run((true,))
    places = np.array(true.places_xy)
    assert ViewOutcome.BLOCKED in {record.outcome for record in object_scan.views}
    assert np.linalg.norm(places - places[-1], axis=1)[8:].max() < 0.1


def test_a_relocalised_robot_completes_the_round() -> None:
    object_scan = scan(poses=Doubtful(after=8, until=24))
    object_scan.run()
    assert object_scan.ended == ROUND_COMPLETE


def test_a_scan_ends_as_soon_as_the_answer_is_confident() -> None:
    likely = ConfidenceRule(coverage=(0.4,), probability=(0.5,))
    object_scan = scan(planner=ConfidencePlanner(), classifier=VolumeClassifier(likely))
    result = object_scan.run()
    assert object_scan.ended.startswith("the answer is confident: ")
    assert 0.4 <= result.last.coverage < 0.8
    assert [step.confident for step in result.steps[-3:]] == [True] * 3
    assert not result.steps[-4].confident


def test_ctrl_c_stops_the_robot_and_saves(ctrl_c_at: Callable[[int], None], tmp_path: Path) -> None:
    ctrl_c_at(4)
    object_scan = scan()
    with pytest.raises(KeyboardInterrupt):
        object_scan.run((RunFolder(tmp_path, {}), ScanFile(object_scan, tmp_path / "scan.json")))
    assert object_scan.ended == EndReason.INTERRUPTED
    assert json.loads((tmp_path / "scan.json").read_text())["ended"] == EndReason.INTERRUPTED
    assert json.loads((tmp_path / "result.json").read_text())["frames"] == 3
    before = object_scan.robot.simulated.truth().T_map_base.translation
    object_scan.robot.wait(1.0)
    after = object_scan.robot.simulated.truth().T_map_base.translation
    assert np.linalg.norm(after - before) < 0.1


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed": 0.0}, {"speed": 5.0}, {"frame_interval": 0.01}, {"frame_interval": 1e9},
        {"max_frames": 0}, {"speed": float("nan")}, {"frame_interval": float("nan")},
        {"turn_between_frames": 0.0}, {"patience": float("nan")}, {"back_off": -0.2},
        {"keep": -1.0}, {"max_blocks": -1}, {"blind_after": float("inf")},
    ],
)  # fmt: skip
def test_invalid_settings_are_refused(wrong) -> None:
    with pytest.raises(InputError):
        ScanSettings(**wrong)


def test_an_early_end_is_reported_with_its_reason() -> None:
    class Full(StepRecorder):
        def on_step(self, step: RecognitionStep) -> None:
            super().on_step(step)
            if len(self.steps) == 3:
                raise OutputError("run/log.jsonl: no space left on device")

    recorder = Full()
    driven = scan()
    with pytest.raises(OutputError):
        driven.run((recorder,))
    assert driven.ended == "interrupted: run/log.jsonl: no space left on device"
    assert recorder.ends[0].end_reason == "run/log.jsonl: no space left on device"
