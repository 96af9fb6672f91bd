from __future__ import annotations

import errno
import json
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import RigidTransform
from small_world import blind, frames, make_pipeline, run

from circumspect.errors import OutputError
from circumspect.geometry import read_cloud, read_tum
from circumspect.grid import OccupancyGrid
from circumspect.recognition import (
    FrameOutcome,
    RecognitionPipeline,
    RecognitionResult,
    RecognitionStep,
    run_pipeline,
)
from circumspect.reconstruction import ObjectModel
from circumspect.runs import RunFolder
from circumspect.runs.run_folder import result_document
from circumspect.sensing import RgbdFrame
from circumspect.tracking import KnownPoses, PoseEstimate, TrackingState

TRACKING, LOST = TrackingState.TRACKING, TrackingState.LOST
DEAD_RECKONING = TrackingState.DEAD_RECKONING
CONFIG = {"command": "test", "truth": "full", "start_deg": 30.0}


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, RecognitionResult]:
    path = tmp_path_factory.mktemp("run") / "deep" / "folder"
    shots = list(frames(5))
    shots[2] = blind(shots[2])
    return path, run(shots, RunFolder(path, CONFIG))


def test_exactly_the_documented_files_are_written(finished: tuple[Path, RecognitionResult]) -> None:
    expected = {
        "config.json", "log.jsonl", "result.json", "model.ply", "grid.npz", "trajectory.txt",
        "picture.png",
    }  # fmt: skip
    assert {file.name for file in finished[0].iterdir()} == expected


def test_log_has_a_line_a_frame(finished: tuple[Path, RecognitionResult]) -> None:
    path, result = finished
    lines = [json.loads(line) for line in (path / "log.jsonl").read_text().splitlines()]
    assert [line["frame"] for line in lines] == [0, 1, 2, 3, 4]
    assert lines[2]["outcome"] == "no depth in the frame"
    assert lines[4]["label"] == result.prediction.label
    assert (lines[4]["state"], lines[4]["reliable"], lines[4]["accurate"]) == (
        "tracking",
        True,
        True,
    )
    assert (lines[4]["source"], lines[4]["pose_reason"]) == ("given", "")
    assert lines[2]["state"] is None


def test_result_is_the_answer(finished: tuple[Path, RecognitionResult]) -> None:
    path, result = finished
    document = json.loads((path / "result.json").read_text())
    assert document["label"] == result.prediction.label
    assert document["probabilities"] == dict(result.prediction.probabilities)
    assert document["truth"] == "full"
    assert document["outcomes"] == {"classified": 4, "no depth in the frame": 1}
    assert document["milliseconds"]["frame"]["median"] >= document["milliseconds"]["fuse"]["median"]
    assert json.loads((path / "config.json").read_text()) == CONFIG
    assert document["points"] == len(read_cloud(path / "model.ply").points_xyz)
    assert document["points"] < len(result.last.model.sums), "outliers are not part of the model"


def test_model_grid_and_trajectory_read_back(finished: tuple[Path, RecognitionResult]) -> None:
    path, result = finished
    cloud = read_cloud(path / "model.ply")
    np.testing.assert_allclose(cloud.points_xyz, result.last.model.cloud().points_xyz, atol=1e-6)
    grid = OccupancyGrid.load(path / "grid.npz")
    np.testing.assert_array_equal(grid.states, result.last.grid.states)
    trajectory = read_tum(path / "trajectory.txt")
    seen = [step for step in result.steps if step.pose is not None]
    np.testing.assert_allclose(trajectory.stamps, [step.stamp for step in seen])
    np.testing.assert_allclose(
        trajectory.positions_xyz, [step.pose.T_map_camera.translation for step in seen], atol=1e-8
    )


def test_the_picture_can_be_opened(finished: tuple[Path, RecognitionResult]) -> None:
    with Image.open(finished[0] / "picture.png") as picture:
        assert picture.size == (1600, 960)
        colours = np.asarray(picture.convert("RGB")).reshape(-1, 3)
    assert len(np.unique(colours, axis=0)) > 500


def test_equal_stamps_keep_the_trajectory_valid(tmp_path: Path) -> None:
    shots = list(frames(3))
    run([shots[0], shots[2], shots[1], shots[2]], RunFolder(tmp_path, CONFIG))
    assert len(read_tum(tmp_path / "trajectory.txt")) == 2


def test_a_run_without_depth_has_no_label_and_counts_outcomes(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path, CONFIG)
    run((blind(frame) for frame in frames(2)), folder)
    document = json.loads((tmp_path / "result.json").read_text())
    assert document["label"] is None
    assert document["outcomes"] == {"no depth in the frame": 2}
    assert folder.picture_missing == "there is no object to show"
    assert not (tmp_path / "model.ply").exists()


@pytest.mark.parametrize(
    ("states", "lost_from"),
    [
        ([TRACKING, TRACKING], None),
        ([TRACKING, DEAD_RECKONING, LOST, None, LOST, None], 1),
        ([TRACKING, LOST, TRACKING], None),
        ([TRACKING, LOST, DEAD_RECKONING], None),
        ([None, None], None),
        ([], None),
    ],
)
def test_lost_from_is_the_first_frame_of_the_final_loss(
    states: list[TrackingState | None], lost_from: int | None
) -> None:
    T = RigidTransform.identity()
    poses = [state and PoseEstimate(T, state) for state in states]
    steps = tuple(
        RecognitionStep(
            number,
            float(number),
            FrameOutcome.NO_POSE,
            pose or None,
            0,
            0.0,
            ObjectModel(),
            None,
            None,
        )
        for number, pose in enumerate(poses)
    )
    result = RecognitionResult(steps)
    assert result.lost_from == lost_from
    assert result_document(result, {})["lost_from"] == lost_from


def test_the_log_gives_the_reason_of_an_unreliable_pose(tmp_path: Path) -> None:
    class UnreliablePoses(KnownPoses):
        def track(self, frame: RgbdFrame) -> PoseEstimate:
            return replace(
                super().track(frame), state=DEAD_RECKONING, reason="2 poses are possible"
            )

    parts = make_pipeline()
    pipeline = RecognitionPipeline(parts.segmentation, UnreliablePoses(), parts.classifier)
    run_pipeline(pipeline, frames(2), (RunFolder(tmp_path, CONFIG),))
    rows = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert [row["pose_reason"] for row in rows] == ["2 poses are possible"] * 2
    assert [row["state"] for row in rows] == ["dead_reckoning"] * 2
    assert [(row["reliable"], row["accurate"]) for row in rows] == [(False, False)] * 2


def test_an_interrupted_run_is_saved(tmp_path: Path) -> None:
    def interrupted():
        yield from frames(2)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(interrupted(), RunFolder(tmp_path, CONFIG))
    document = json.loads((tmp_path / "result.json").read_text())
    assert document["interrupted"] is True
    assert document["frames"] == 2
    assert (tmp_path / "picture.png").exists()
    assert (tmp_path / "model.ply").exists()


def test_a_run_that_is_interrupted_before_its_first_pose_and_answer_is_saved(
    tmp_path: Path, finished: tuple[Path, RecognitionResult]
) -> None:
    """As Ctrl-C may come between the first grid and its answer."""
    steps = tuple(replace(step, pose=None, prediction=None) for step in finished[1].steps)
    RunFolder(tmp_path, CONFIG).on_end(RecognitionResult(steps, interrupted=True))
    document = json.loads((tmp_path / "result.json").read_text())
    assert (document["label"], document["interrupted"]) == (None, True)
    assert (tmp_path / "picture.png").exists()


def test_without_matplotlib_all_but_the_picture_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    folder = RunFolder(tmp_path, CONFIG)
    run(frames(1), folder)
    assert 'pip install "circumspect[figures]"' in folder.picture_missing
    assert not (tmp_path / "picture.png").exists()
    assert (tmp_path / "grid.npz").exists()


def test_a_truncated_last_line_is_not_joined_with_the_next(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path, CONFIG)
    (tmp_path / "log.jsonl").write_text('{"frame": 0}\n{"fra')
    run(frames(1), folder)
    lines = (tmp_path / "log.jsonl").read_text().splitlines()
    assert [json.loads(line)["frame"] for line in lines] == [0, 0]


def test_files_of_an_earlier_run_are_replaced(tmp_path: Path) -> None:
    for count in (3, 1):
        run(frames(count), RunFolder(tmp_path, CONFIG))
    assert len((tmp_path / "log.jsonl").read_text().splitlines()) == 1
    assert json.loads((tmp_path / "result.json").read_text())["frames"] == 1


@pytest.mark.parametrize("name", ["calibration.json", "model.ply", "config.json", "playback"])
def test_a_foreign_file_is_not_replaced(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    (tmp_path / "chair.obj").write_text("mine")
    with pytest.raises(OutputError, match=rf"{name}: is of no such run"):
        RunFolder(tmp_path, CONFIG)
    assert (tmp_path / name).read_text() == "mine"
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted([name, "chair.obj"])


@pytest.mark.parametrize("name", ["picture.png", "playback/000001.npz", "replay.json"])
def test_a_folder_in_the_place_of_a_file_is_refused_before_anything_is_changed(
    tmp_path: Path, name: str
) -> None:
    run(frames(1), RunFolder(tmp_path, CONFIG))
    (tmp_path / name).unlink(missing_ok=True)
    (tmp_path / name).mkdir(parents=True)
    with pytest.raises(OutputError, match=rf"{name}: is a folder"):
        RunFolder(tmp_path, {"command": "another"})
    assert json.loads((tmp_path / "config.json").read_text()) == CONFIG
    assert (tmp_path / "log.jsonl").read_text()
    assert (tmp_path / "result.json").exists()


def test_a_file_that_can_not_be_removed_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(frames(1), RunFolder(tmp_path, CONFIG))

    def refused(path: Path, missing_ok: bool = False) -> None:
        raise PermissionError(errno.EPERM, "Operation not permitted", str(path))

    monkeypatch.setattr("circumspect.runs.run_folder.Path.unlink", refused)
    with pytest.raises(OutputError, match=r"can not be removed \(operation not permitted\)"):
        RunFolder(tmp_path, CONFIG)


def test_planning_is_part_of_the_time_of_a_frame(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path, CONFIG)
    folder.scan = SimpleNamespace(plan_milliseconds=[1000.0, 3000.0], views=())
    run(frames(2), folder)
    times = json.loads((tmp_path / "result.json").read_text())["milliseconds"]
    assert times["plan"]["median"] == 2000
    assert times["frame"]["median"] > 2000


def test_other_files_in_the_folder_are_kept(tmp_path: Path) -> None:
    (tmp_path / "chair.obj").write_text("mine")
    for _ in range(2):
        RunFolder(tmp_path, CONFIG)
    assert (tmp_path / "chair.obj").read_text() == "mine"


def test_an_unwritable_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OutputError, match="file"):
        RunFolder(tmp_path / "file" / "run", CONFIG)


def test_an_unwritable_log_is_named(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path, CONFIG)
    (tmp_path / "log.jsonl").unlink()
    (tmp_path / "log.jsonl").mkdir()
    with pytest.raises(OutputError, match=r"log\.jsonl"):
        run(frames(1), folder)
