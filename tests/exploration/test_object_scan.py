"""The loop of a scan on a simulated robot: its rounds, its ends, its faults."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scan_world import NOTHING, QUICK, scan, start, wall
from small_world import Diary
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
from circumspect.simulation.motion_faults import Blocked
from circumspect.simulation.odometry_faults import OdometryGone, OdometryStuck
from circumspect.tracking import KnownPoses, PoseEstimate, TrackingState


@pytest.mark.parametrize("planner", [SurfaceNormalPlanner(), CirclePlanner()])
def test_a_box_is_gone_round_and_all_of_it_is_written_down(planner, tmp_path: Path) -> None:
    going = scan(planner=planner)
    folder = RunFolder(tmp_path, {"command": "test"})
    log, file = RunPathLog(going, folder), ScanFile(going, tmp_path / "scan.json")
    result = going.run((log, file, folder))
    assert going.ended == ROUND_COMPLETE
    assert result.prediction is not None
    assert result.last.coverage == 1.0
    assert all(record.outcome == ViewOutcome.REACHED for record in going.views)
    # No shorter than the circle that just clears the box, no longer than twice the wanted one.
    assert 2 * np.pi * 0.6 < going.driven_m < 2 * 2 * np.pi * 1.3
    document = json.loads((tmp_path / "scan.json").read_text())
    assert document["ended"] == ROUND_COMPLETE
    assert len(document["views"]) == len(going.views) >= 5
    assert document["turned_deg"] > 330
    assert len((tmp_path / "log.jsonl").read_text().splitlines()) == len(result.steps)
    assert (tmp_path / "picture.png").exists()


def test_planner_that_returns_something_else_is_named() -> None:
    class Odd(CirclePlanner):
        def next_view(self, situation):
            return None

    going = scan(planner=Odd())
    with pytest.raises(InputError, match="planner Odd returned a NoneType; a NextView or Finished"):
        going.run()


def test_the_robot_never_touches_what_it_scans() -> None:
    going = scan(planner=SurfaceNormalPlanner())
    wait, places = going.robot.wait, []

    def waited(seconds: float) -> None:
        wait(seconds)
        places.append(going.robot.simulated.truth().T_map_base.translation[:2])

    going.robot.wait = waited
    going.run()
    beyond = np.maximum(np.abs(places) - [0.25, 0.2], 0)
    assert np.hypot(*beyond.T).min() > going.robot.radius


def test_the_same_seed_gives_the_same_scan() -> None:
    told = []
    for _ in range(2):
        going = scan(seed=4, settings=replace(QUICK, most_frames=12))
        result = going.run()
        told.append((going.driven_m, result.last.prediction, len(result.last.model.sums)))
    assert told[0] == told[1]


def test_the_object_is_looked_for_where_the_robot_looks_away() -> None:
    going = scan(pose=start(askew=2.5), settings=replace(QUICK, most_frames=30))
    result = going.run()
    outcomes = [step.outcome for step in result.steps]
    assert outcomes[0] == "no object in view"
    assert "classified" in outcomes
    assert going.ended == "the limit of 30 frames is reached"


def test_no_object_ends_after_one_look_round(tmp_path: Path) -> None:
    going = scan(mesh=NOTHING)
    result = going.run((RunFolder(tmp_path, {}), ScanFile(going, tmp_path / "scan.json")))
    assert going.ended == "no object in view after a look round"
    assert 24 <= len(result.steps) <= 32
    assert result.points_xyz.shape == (0, 3)
    assert going.views == []
    assert json.loads((tmp_path / "result.json").read_text())["label"] is None
    assert json.loads((tmp_path / "scan.json").read_text())["ended"] == going.ended


def test_an_object_larger_than_the_room_ends_with_the_reason_and_no_conclusion(
    tmp_path: Path,
) -> None:
    bar = block((-0.2, -2.4, 0.0), (0.2, 2.4, 0.7))
    walls = (
        wall((-2.6, 2.4), (2.6, 2.5)), wall((-2.6, -2.5), (2.6, -2.4)),
        wall((2.4, -2.5), (2.5, 2.5)), wall((-2.5, -2.5), (-2.4, 2.5)),
    )  # fmt: skip
    going = scan(mesh=bar, others=walls, pose=PlanarPose(1.5, -0.3, np.pi / 2))
    result = going.run((RunFolder(tmp_path, {}), ScanFile(going, tmp_path / "scan.json")))
    told = json.loads((tmp_path / "result.json").read_text())
    assert (told["frames"], told["confident"]) == (len(result.steps), False)
    assert json.loads((tmp_path / "scan.json").read_text())["ended"] == going.ended
    assert (tmp_path / "trajectory.txt").exists()
    assert going.ended.startswith((ALL_TRIED, AS_FAR_AS_POSSIBLE, "blocked 3 times"))
    assert len(result.steps) < 200
    assert result.last.coverage < 0.8


def test_a_side_against_the_wall_is_left_out_and_the_others_are_seen() -> None:
    behind = wall((-1.0, -2.0), (-0.9, 2.0))
    going = scan(others=(behind,), planner=CirclePlanner(), pose=start(-60))
    going.run()
    assert going.ended.startswith((ALL_TRIED, AS_FAR_AS_POSSIBLE))
    missed = [record for record in going.views if record.outcome != ViewOutcome.REACHED]
    assert missed
    assert sum(record.outcome == ViewOutcome.REACHED for record in going.views) >= 4


def test_a_robot_that_is_held_gives_up_with_what_it_has(tmp_path: Path) -> None:
    going = scan(fault=lambda robot: Blocked(robot, after=6.0, seconds=1e6))
    result = going.run((RunFolder(tmp_path, {}),))
    assert going.ended == "blocked 3 times: nothing more can be reached"
    assert ViewOutcome.BLOCKED in {record.outcome for record in going.views}
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
def test_the_round_is_completed_in_spite_of(fault) -> None:
    going = scan(fault=fault)
    going.run()
    assert going.ended == ROUND_COMPLETE


class Doubtful(KnownPoses):
    """From some frame on it does not know where it is."""

    def __init__(self, after: int, until: int = 10**6) -> None:
        self.count, self.after, self.until = 0, after, until

    def track(self, frame: RgbdFrame) -> PoseEstimate:
        self.count += 1
        known = super().track(frame)
        if not self.after <= self.count < self.until:
            return known
        return replace(known, state=TrackingState.LOST, reason="the scans contradict the map")


def test_a_robot_that_is_lost_for_good_says_so() -> None:
    going = scan(poses=Doubtful(after=8))
    result = going.run()
    assert going.ended == EndReason.LOST
    assert len(result.steps) < 60
    assert result.steps[-1].prediction == result.steps[6].prediction


class TruePlaces:
    """Where the robot really was at each frame."""

    def __init__(self, robot: SimulatedRobot) -> None:
        self.robot, self.places_xy = robot, []

    def on_step(self, step: RecognitionStep) -> None:
        self.places_xy.append(self.robot.truth().T_map_base.translation[:2])

    def on_end(self, result: RecognitionResult) -> None:
        pass


@pytest.mark.parametrize("fault", [None, lambda robot: OdometryGone(robot)])
def test_a_robot_that_lost_its_way_looks_round_where_it_last_knew_it(fault) -> None:
    going = scan(poses=Doubtful(after=8), fault=fault)
    true = TruePlaces(going.robot.simulated)
    going.run((true,))
    assert going.ended == EndReason.LOST
    places = np.array(true.places_xy)
    off = np.linalg.norm(places - places[6], axis=1)
    assert off.max() > 0.5
    assert off[-1] < 0.1


def test_what_a_robot_commanded_in_vain_it_does_not_take_back() -> None:
    """Nobody knows what is behind it."""
    going = scan(poses=Doubtful(after=9), fault=lambda robot: Blocked(robot, 6.0, 6.0))
    true = TruePlaces(going.robot.simulated)
    going.run((true,))
    places = np.array(true.places_xy)
    assert ViewOutcome.BLOCKED in {record.outcome for record in going.views}
    assert np.linalg.norm(places - places[-1], axis=1)[8:].max() < 0.1


def test_a_robot_that_finds_itself_again_goes_on() -> None:
    going = scan(poses=Doubtful(after=8, until=24))
    going.run()
    assert going.ended == ROUND_COMPLETE


def test_a_scan_ends_as_soon_as_the_answer_is_confident() -> None:
    likely = ConfidenceRule(coverage=(0.4,), probability=(0.5,))
    going = scan(planner=ConfidencePlanner(), classifier=VolumeClassifier(likely))
    result = going.run()
    assert going.ended.startswith("the answer is confident: ")
    assert 0.4 <= result.last.coverage < 0.8
    assert [step.confident for step in result.steps[-3:]] == [True] * 3
    assert not result.steps[-4].confident


def test_ctrl_c_stops_the_robot_and_saves(ctrl_c_at: Callable[[int], None], tmp_path: Path) -> None:
    ctrl_c_at(4)
    going = scan()
    with pytest.raises(KeyboardInterrupt):
        going.run((RunFolder(tmp_path, {}), ScanFile(going, tmp_path / "scan.json")))
    assert going.ended == EndReason.INTERRUPTED
    assert json.loads((tmp_path / "scan.json").read_text())["ended"] == EndReason.INTERRUPTED
    assert json.loads((tmp_path / "result.json").read_text())["frames"] == 3
    before = going.robot.simulated.truth().T_map_base.translation
    going.robot.wait(1.0)
    after = going.robot.simulated.truth().T_map_base.translation
    assert np.linalg.norm(after - before) < 0.1


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed": 0.0}, {"speed": 5.0}, {"frame_interval": 0.01}, {"frame_interval": 1e9},
        {"most_frames": 0}, {"speed": float("nan")}, {"frame_interval": float("nan")},
        {"turn_between_frames": 0.0}, {"patience": float("nan")}, {"back_off": -0.2},
        {"keep": -1.0}, {"most_blocks": -1}, {"blind_after": float("inf")},
    ],
)  # fmt: skip
def test_settings_that_make_no_sense_are_refused(wrong) -> None:
    with pytest.raises(InputError):
        ScanSettings(**wrong)


def test_what_ended_a_scan_early_is_told_with_its_reason() -> None:
    class Full(Diary):
        def on_step(self, step: RecognitionStep) -> None:
            super().on_step(step)
            if len(self.steps) == 3:
                raise OutputError("run/log.jsonl: no space left on device")

    diary = Full()
    driven = scan()
    with pytest.raises(OutputError):
        driven.run((diary,))
    assert driven.ended == "interrupted: run/log.jsonl: no space left on device"
    assert diary.ends[0].end_reason == "run/log.jsonl: no space left on device"
