"""Run folders: complete, old, interrupted, broken, and untrusted."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from circumspect.cli.main import main
from circumspect.errors import InputError
from circumspect.geometry import read_cloud
from circumspect.viewer import PlayedRun, SavedRun
from circumspect.viewer.older_keys import with_todays_keys
from circumspect.viewer.panel_html import answer_html, faults_html


def test_a_finished_run_can_be_shown_at_every_frame(finished_run):
    run = SavedRun.load(finished_run)
    assert run.missing == ()
    played = PlayedRun(run)
    assert len(played) == 6
    rows = [json.loads(line) for line in (finished_run / "log.jsonl").read_text().splitlines()]
    ended = json.loads((finished_run / "result.json").read_text())
    for frame in range(6):
        shown = played.state_at(frame)
        row = ended if frame == 5 else rows[frame]
        assert shown.row["label"] == row["label"]
        assert shown.row["probabilities"] == row["probabilities"]
        assert shown.images.frame == frame
        assert shown.images.depth.shape == (120, 160)
        assert shown.T_map_camera is not None
        assert len(shown.path_xyz) == frame + 1
        assert len(shown.odometry_xyz) == frame + 1
        np.testing.assert_allclose(shown.path_xyz[-1], shown.T_map_camera.translation)
        assert shown.truth == "chair"
    assert len(shown.surroundings.meshes) >= 4
    final = read_cloud(finished_run / "model.ply")
    np.testing.assert_array_equal(shown.object_snapshot.points_xyz, final.points_xyz)
    assert len(shown.object_snapshot.frames_seen) == len(final)
    assert shown.object_snapshot.frames_seen.max() > 1


def test_the_object_snapshot_grows(finished_run):
    played = PlayedRun(SavedRun.load(finished_run))
    counts = [len(played.state_at(frame).object_snapshot.points_xyz) for frame in range(6)]
    assert counts[0] > 100
    assert counts[-1] > counts[0]


def test_a_run_without_playback_is_shown_with_a_note(copied_run):
    shutil.rmtree(copied_run / "playback")
    run = SavedRun.load(copied_run)
    assert len(run.missing) == 1
    assert "kept no moments" in run.missing[0]
    shown = PlayedRun(run).state_at(5)
    assert shown.images is None
    assert len(shown.object_snapshot.points_xyz) > 100
    assert "kept no moments" in shown.message
    assert len(PlayedRun(run).state_at(0).object_snapshot.points_xyz) == 0


def test_a_killed_run_is_shown_up_to_its_last_frame(copied_run):
    """No end was written, and the last line is cut."""
    for name in ("result.json", "trajectory.txt", "model.ply", "grid.npz", "picture.png"):
        (copied_run / name).unlink()
    (copied_run / "playback" / "odometry.npz").unlink()
    log = copied_run / "log.jsonl"
    log.write_text(log.read_text()[:-40])
    run = SavedRun.load(copied_run)
    assert len(run.rows) == 5
    assert len(run.missing) == 4
    shown = PlayedRun(run).state_at(4)
    assert len(shown.path_xyz) == 5
    assert len(shown.object_snapshot.points_xyz) > 100


@pytest.mark.parametrize("name", ["000000.npz", "surroundings.npz", "odometry.npz"])
def test_a_broken_playback_file_is_skipped(copied_run, name):
    (copied_run / "playback" / name).write_bytes(b"PK\x03\x04 broken")
    run = SavedRun.load(copied_run)
    shown = PlayedRun(run).state_at(5)
    assert len(shown.object_snapshot.points_xyz) > 100
    assert any(name in reason for reason in run.missing) or name == "000000.npz"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("config.json", "[1, 2]", "config.json"),
        ("config.json", "{", "broken JSON"),
        ("config.json", "[" * 100_000, "broken JSON"),
        ("log.jsonl", "not json\n{}\n", "line 1 is broken"),
        ("log.jsonl", '{"frame": "x"}\n{}\n', "line 1 is broken"),
        ("log.jsonl", "[]\n[]\n", "line 1 is broken"),
        ("log.jsonl", '{"frame": Infinity, "stamp": 0.0}\n', "line 1 is broken"),
        ("log.jsonl", '{"frame": 0, "stamp": NaN}\n', "line 1 is broken"),
        ("log.jsonl", f'{{"frame": 0, "stamp": {10**400}}}\n', "line 1 is broken"),
    ],
)
def test_an_invalid_run_folder_gives_one_line(copied_run, name, text, words, capsys):
    (copied_run / name).write_text(text)
    with pytest.raises(InputError, match=words):
        SavedRun.load(copied_run)
    assert main(["view", str(copied_run)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_invalid_entries_of_the_log_are_skipped(copied_run):
    row = {
        "frame": 0, "stamp": 1.0, "probabilities": {"a": "b", "c": float("nan"), "d": 0.5},
        "coverage": "much", "points": None, "milliseconds": [1], "camera_xyz": [1, 2],
        "label": "<b>" * 1000, "surprise": "x", "in_distribution": "no",
        "confident": 1, "alternatives": ["a"],
    }  # fmt: skip
    (copied_run / "log.jsonl").write_text(json.dumps(row) + "\n")
    (copied_run / "result.json").unlink()
    (read,) = SavedRun.load(copied_run).rows
    assert read["probabilities"] == {"d": 0.5}
    assert set(read) == {"frame", "stamp", "probabilities", "label"}
    assert len(read["label"]) <= 300


@pytest.mark.parametrize("share", ["coverage", "seen"])
@pytest.mark.parametrize("number", ["Infinity", "1e308", "1" * 400])
def test_infinite_and_huge_numbers_are_skipped(copied_run, number, share):
    row = (
        f'{{"frame": 0, "stamp": 1.0, "label": "a", "conclusive": false, "points": {number}, '
        f'"probability": {number}, "{share}": {number}, "camera_xyz": [0, {number}, 0], '
        f'"probabilities": {{"a": {number}}}, "milliseconds": {{"a": {number}}}}}'
    )
    (copied_run / "log.jsonl").write_text(row + "\n")
    (copied_run / "result.json").unlink()
    (read,) = SavedRun.load(copied_run).rows
    assert isinstance(read.pop("reason", ""), str)
    assert read == {
        "label": "a", "frame": 0, "stamp": 1.0, "confident": False, "probabilities": {}, "milliseconds": {},
    }  # fmt: skip


def with_answer(run: Path, answer: dict[str, Any], drop: tuple[str, ...] = ()) -> None:
    """Give every row and the result this answer; leave out keys that a version did not write."""
    log, ended = run / "log.jsonl", run / "result.json"
    rows = [json.loads(line) for line in log.read_text().splitlines()]
    kept = [{k: v for k, v in row.items() if k not in drop} | answer for row in rows]
    log.write_text("".join(json.dumps(row) + "\n" for row in kept))
    result = {k: v for k, v in json.loads(ended.read_text()).items() if k not in drop}
    ended.write_text(json.dumps(result | answer))


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        ({"confident": True, "reason": ""}, None),
        (
            {"confident": False, "reason": "at least 75 % coverage is needed"},
            "not confident: at least 75 % coverage is needed",
        ),
        (
            {"in_distribution": False, "confident": False, "reason": "unlike"},
            "not confident: unlike",
        ),
    ],
)
def test_the_playback_shows_why_an_answer_is_not_confident(copied_run, answer, text):
    with_answer(copied_run, answer)
    shown = answer_html(PlayedRun(SavedRun.load(copied_run)).state_at(5).row)
    assert text is None or text in shown
    assert ("not confident" in shown) == (text is not None)
    assert ("unknown object" in shown) == ("in_distribution" in answer)


TODAYS = ("in_distribution", "confident", "reason", "alternatives", "coverage", "end_reason")


@pytest.mark.parametrize(
    ("known", "conclusive", "seen", "probability", "reason"),
    [
        (True, True, 1.0, 0.95, None),
        (False, False, 1.0, 0.95, "the object is unlike the trained classes"),
        (True, False, 0.7, 0.95, "at least 75 % coverage is needed"),
        (True, False, 0.8, 0.6, "a probability of at least 90 % is needed"),
    ],
)
def test_keys_of_older_versions_are_read_as_those_of_today(
    copied_run, known, conclusive, seen, probability, reason
):
    older = {"known": known, "conclusive": conclusive, "seen": seen, "probability": probability}
    with_answer(copied_run, older, drop=TODAYS)
    ended = copied_run / "result.json"
    ended.write_text(json.dumps(json.loads(ended.read_text()) | {"reason": "the disk is full"}))
    run = SavedRun.load(copied_run)
    for row in run.rows:
        assert (row["in_distribution"], row["confident"]) == (known, conclusive)
        assert (row["coverage"], row.get("reason")) == (seen, reason)
        assert not set(row) & {"known", "conclusive", "seen"}
    assert run.result["end_reason"] == "the disk is full"
    assert run.result["reason"] == reason
    shown = answer_html(PlayedRun(run).state_at(5).row)
    assert reason is None or f"not confident: {reason}" in shown


POSE_KEYS = ("state", "pose_reason", "source", "reliable", "accurate")


@pytest.mark.parametrize(
    ("gate", "doubt", "reason"),
    [
        ("open", "", ""),
        ("too few inliers", "", "too few inliers"),
        ("open", "2 frames must agree first", "2 frames must agree first"),
        ("lost: too few inliers", "a frame", "lost: too few inliers; a frame"),
    ],
)
def test_pose_keys_of_older_versions_are_read_as_those_of_today(copied_run, gate, doubt, reason):
    log = copied_run / "log.jsonl"
    older = {"gate": gate, "doubt": doubt, "certain": not doubt, "sure": False, "prior": "odometry"}
    rows = [json.loads(line) for line in log.read_text().splitlines()]
    kept = [{k: v for k, v in row.items() if k not in POSE_KEYS} | older for row in rows]
    log.write_text("".join(json.dumps(row) + "\n" for row in kept))
    today = with_todays_keys(kept[0])
    assert (today["reliable"], today["accurate"], today["source"]) == (not doubt, False, "odometry")
    assert not set(today) & set(older)
    loaded = SavedRun.load(copied_run).rows
    assert [row.get("pose_reason") for row in loaded] == [reason] * len(rows)
    shown = faults_html(loaded, len(rows))
    assert (reason or "no fault, all poses reliable") in shown


def test_a_folder_without_a_run_is_refused_with_the_remedy(tmp_path, capsys):
    assert main(["view", str(tmp_path / "none")]) == 2
    assert "no such folder" in capsys.readouterr().err
    assert main(["view", str(tmp_path)]) == 2
    assert "circumspect scan" in capsys.readouterr().err
    (tmp_path / "config.json").write_text("{}")
    (tmp_path / "log.jsonl").write_text("")
    assert main(["view", str(tmp_path)]) == 2
    assert "no frames" in capsys.readouterr().err


def test_a_missing_viser_names_the_extra(finished_run, monkeypatch, capsys):
    monkeypatch.setitem(__import__("sys").modules, "viser", None)
    assert main(["view", str(finished_run)]) == 2
    assert 'pip install "circumspect[viewer]"' in capsys.readouterr().err
