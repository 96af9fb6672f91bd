"""`classify` on scans: floors, stray points, unknown up, y-up files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scanned_floor import on_floor
from scipy.spatial.transform import Rotation

from circumspect.classification import Classifier, classify_any_way_up
from circumspect.classification.upright import ways_up
from circumspect.cli.main import main
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud


@pytest.fixture(scope="module")
def classifier() -> Classifier:
    return Classifier.load(threads=1)


def classified(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[dict, str]:
    """The record of one file, and standard error."""
    assert main(["classify", "--json", "--threads", "1", *map(str, words)]) == 0
    captured = capsys.readouterr()
    return json.loads(captured.out), captured.err


def saved(folder: Path, points: np.ndarray) -> Path:
    np.save(folder / "scan.npy", points)
    return folder / "scan.npy"


@pytest.mark.parametrize("category", ["chair", "table", "toilet"])
def test_cut_floor_names_the_object_and_reports_what_it_removed(category, tmp_path, capsys):
    points, _ = on_floor(category, 5, noise=0.003, wall=True)
    file = saved(tmp_path, points)
    record, stderr = classified(capsys, file, "--cut-floor", "--unit", "m")
    assert (record["label"], record["in_distribution"]) == (category, True)
    floor = record["floor"]
    assert floor["floor_points"] + floor["other_points"] + record["points"] == len(points)
    assert f"scan.npy: cut off {floor['floor_points']} points of the floor" in stderr
    assert "--cut-floor" not in stderr
    plain, stderr = classified(capsys, file, "--unit", "m")
    assert not plain["confident"]
    assert "floor" not in plain
    assert "seems to hold the floor, too; cut it off: --cut-floor" in stderr


def test_without_a_floor_the_cloud_is_unchanged(tmp_path, capsys):
    file = saved(tmp_path, make_furniture("chair", 3).sampled(8000, 0).points_xyz)
    record, stderr = classified(capsys, file, "--cut-floor")
    assert "no floor found; nothing was cut off" in stderr
    assert (record["label"], record["points"]) == ("chair", 8000)


def test_the_floor_gives_the_up_axis(tmp_path, capsys):
    turn = Rotation.from_rotvec([2.0, 0.5, -0.3])
    points, _ = on_floor("chair", noise=0.003)
    file = saved(tmp_path, turn.apply(points))
    record, stderr = classified(capsys, file, "--cut-floor", "--up", "auto")
    assert record["label"] == "chair"
    np.testing.assert_allclose(record["up_xyz"], turn.apply([0, 0, 1]), atol=0.02)
    assert "cut off" in stderr


@pytest.mark.parametrize("category", ["chair", "bed", "night_stand", "monitor"])
@pytest.mark.parametrize("turned", [False, True])
def test_auto_accepts_no_object_with_a_floor(category, turned, tmp_path, capsys):
    points, _ = on_floor(category, noise=0.002)
    if turned:
        points = Rotation.from_rotvec([np.pi / 2, 0, 0]).apply(points)
    record, stderr = classified(capsys, saved(tmp_path, points), "--up", "auto")
    assert not record["in_distribution"]
    assert "--cut-floor" in stderr


def test_auto_tries_the_pose_of_the_file_first(classifier):
    kept = 0
    for category in ("chair", "table", "bed", "toilet", "sofa", "desk"):
        cloud = make_furniture(category, 5).sampled(6000, 0)
        ways = ways_up(classifier, cloud)
        assert sum(way.upright for way in ways) == 1
        kept += ways[0].upright
    assert kept >= 5


def test_auto_reports_a_close_second(classifier):
    """Some objects have a second pose with another label; their answers are not confident."""
    close = 0
    for number, category in enumerate(("night_stand", "dresser", "monitor", "desk") * 2):
        cloud = make_furniture(category, number).sampled(4000, number)
        ways = ways_up(classifier, cloud)
        prediction, pose = classify_any_way_up(classifier, cloud)
        assert pose.approx_equal(ways[0].pose, 1e-9)
        others = [way for way in ways if way.prediction.label != ways[0].prediction.label]
        if others and others[0].score > 0.9 * ways[0].score:
            close += 1
            assert not prediction.confident
            assert f"it is a {others[0].prediction.label}" in prediction.ambiguity
        else:
            assert prediction.ambiguity == ""
    assert close >= 1


def test_a_pose_in_distribution_takes_precedence_over_a_more_probable_one(classifier):
    rng = np.random.default_rng(3)
    for number in range(3):
        cloud = PointCloud(rng.normal(size=(3000, 3)) * [1, 0.7, 0.3 + number])
        known = [way.prediction.in_distribution for way in ways_up(classifier, cloud)]
        assert known == sorted(known, reverse=True)


@pytest.mark.parametrize("strays", [1, 8])
def test_stray_points_do_not_set_the_scale(strays, tmp_path, capsys):
    points = make_furniture("chair", 3).sampled(6000, 0).points_xyz
    far = np.random.default_rng(0).normal(size=(strays, 3)) * 40
    record, stderr = classified(capsys, saved(tmp_path, np.concatenate([points, far])))
    assert (record["label"], record["confident"]) == ("chair", True)
    assert f"scan.npy: ignored {strays} of {6000 + strays} points far from all others" in stderr


def test_missing_points_are_counted_on_standard_error(tmp_path, capsys):
    points = make_furniture("chair", 3).sampled(6000, 0).points_xyz.copy()
    points[:60] = np.nan
    points[60:1060] = 0
    record, stderr = classified(capsys, saved(tmp_path, points))
    assert record["label"] == "chair"
    assert "scan.npy: ignored 60 of 6000 points that are NaN or infinite" in stderr
    assert "scan.npy: ignored 1000 of 6000 points at (0, 0, 0)" in stderr


def test_a_glb_stands_upright_by_default(tmp_path, capsys):
    mesh = make_furniture("chair", 3)
    x, y, z = mesh.vertices_xyz.T
    scene = trimesh.Trimesh(np.stack([x, z, -y], axis=1), mesh.faces, process=False)
    (tmp_path / "chair.glb").write_bytes(scene.export(file_type="glb"))
    record, stderr = classified(capsys, tmp_path / "chair.glb")
    assert (record["label"], record["confident"], stderr) == ("chair", True, "")
    record, _ = classified(capsys, tmp_path / "chair.glb", "--up", "z")
    assert record["label"] != "chair" or not record["confident"]


def test_a_broken_file_does_not_stop_the_others(tmp_path, capsys):
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (True, 3)}"
    bad = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(24)
    (tmp_path / "bad.npy").write_bytes(bad)
    good = saved(tmp_path, make_furniture("chair", 3).sampled(6000, 0).points_xyz)
    assert main(["classify", str(tmp_path / "bad.npy"), str(good)]) == 2
    captured = capsys.readouterr()
    assert "scan.npy: chair" in captured.out
    assert captured.err.count("\n") == 1
    assert "bad.npy: is no readable NPY file" in captured.err
