import json
import os

import numpy as np
import pytest
from scanned_floor import on_floor
from scipy.spatial.transform import Rotation

from circumspect.classification import Classifier
from circumspect.classification.evidence_plot import evidence_colours, evidence_span
from circumspect.classification.explanation import explain_grid
from circumspect.cli.main import main
from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud, read_cloud, write_ply
from circumspect.geometry.formats.ply_file import write_coloured_ply
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid
from circumspect.grid.cell_centres import occupied_centres

MODELNET10 = ("--model", "modelnet10")
"""Where a test is about the answers of this network or its training objects."""


def run(*words):
    return main([str(word) for word in words])


@pytest.fixture(scope="module")
def chair(tmp_path_factory):
    path = tmp_path_factory.mktemp("files") / "chair.ply"
    write_ply(path, make_furniture("chair", 3).sampled(20_000, 0))
    return path


@pytest.fixture(autouse=True)
def _coarse_blocks_and_few_points(monkeypatch):
    """Coarse blocks and few points take a tenth of the time."""
    from circumspect.classification import evidence
    from circumspect.evaluation import evidence_picture

    monkeypatch.setattr(evidence.cell_evidence, "__defaults__", (None, (1.0,), None))
    monkeypatch.setattr(evidence_picture, "MAX_POINTS", 1000)


def test_one_file_in_an_answer_and_three_files_out(chair, tmp_path, capsys):
    assert run("explain", chair, "--out", tmp_path / "why", "--json", *MODELNET10) == 0
    out, err = capsys.readouterr()
    record = json.loads(out)
    assert (record["label"], record["explained"], err) == ("chair", "chair", "")
    assert [n["label"] for n in record["nearest"]] == ["chair"] * 5
    assert 0 < record["evidence"]["half_of_it_in"] < 0.5
    assert record["evidence"]["least"] < record["evidence"]["most"]
    assert {p.name for p in (tmp_path / "why").iterdir()} == {
        "chair-why.npz", "chair-why.ply", "chair-why.png"
    }  # fmt: skip
    assert (tmp_path / "why" / "chair-why.png").read_bytes()[:4] == b"\x89PNG"
    cloud = read_cloud(tmp_path / "why" / "chair-why.ply")
    np.testing.assert_array_equal(cloud.points_xyz, read_cloud(chair).points_xyz)
    header = (tmp_path / "why" / "chair-why.ply").read_bytes()[:400].decode("latin-1")
    assert "property uchar red" in header
    assert "property float evidence" in header
    with np.load(tmp_path / "why" / "chair-why.npz", allow_pickle=False) as stored:
        assert stored["evidence"].shape == stored["states"].shape == (32, 32, 32)
        assert (stored["evidence"][stored["states"] != 2] == 0).all()
        assert stored["evidence"].max() == pytest.approx(record["evidence"]["most"], abs=1e-4)


def test_the_answer_is_that_of_classify(chair, tmp_path, capsys):
    run("classify", chair, "--json", "--threads", 1)
    run("explain", chair, "--json", "--out", tmp_path, "--threads", 1)
    named, why = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert why["probabilities"] == named["probabilities"]
    assert why["points"] == named["points"]


def test_a_lying_chair_is_stood_up_and_shown_so(tmp_path, capsys):
    cloud = make_furniture("chair", 3).sampled(20_000, 0)
    lying = PointCloud(cloud.points_xyz[:, [1, 2, 0]])
    write_ply(tmp_path / "lying.ply", lying)
    words = (tmp_path / "lying.ply", "--up", "auto", "--json", "--threads", 1)
    run("classify", *words)
    run("explain", *words, "--out", tmp_path, "--near", 1)
    named, why = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert why["up_xyz"] == named["up_xyz"] == pytest.approx([0.0, 1.0, 0.0], abs=0.02)
    assert why["probabilities"] == named["probabilities"]
    shown = read_cloud(tmp_path / "lying-why.ply")
    assert np.ptp(shown.points_xyz[:, 2]) == pytest.approx(np.ptp(cloud.points_xyz[:, 2]), abs=0.02)
    run("explain", *words[:3], "--out", tmp_path, "--near", 0)
    assert "; up is (" in capsys.readouterr().out.splitlines()[0]


def test_cut_floor_explains_the_object_alone_as_classify_names_it(tmp_path, capsys):
    points, _ = on_floor("chair", 5, noise=0.003, lean=0.1, wall=True, points=24_000)
    np.save(tmp_path / "scan.npy", points)
    words = (tmp_path / "scan.npy", "--unit", "m", "--json", "--threads", 1)
    run("classify", *words, "--cut-floor")
    run("explain", *words, "--cut-floor", "--out", tmp_path, "--near", 0)
    out, err = capsys.readouterr()
    named, why = (json.loads(line) for line in out.splitlines())
    assert err.count("scan.npy: cut off ") == 2
    assert "--cut-floor" not in err
    assert (why["label"], why["explained"]) == ("chair", "chair")
    for key in ("probabilities", "points", "floor", "confident"):
        assert why[key] == named[key], key
    shown = read_cloud(tmp_path / "scan-why.ply").points_xyz
    assert len(shown) == why["points"] < len(points)
    low, high = np.quantile(shown[:, 2], [0.001, 0.999])
    assert high - low < 1.2 * np.ptp(make_furniture("chair", 5).vertices_xyz[:, 2]), "levelled"


def test_the_floor_gives_the_up_axis_of_the_explained_object(tmp_path, capsys):
    turn = Rotation.from_rotvec([2.0, 0.5, -0.3])
    points, _ = on_floor("chair", noise=0.003)
    np.save(tmp_path / "scan.npy", turn.apply(points))
    words = (tmp_path / "scan.npy", "--cut-floor", "--up", "auto", "--near", 0, "--json")
    assert run("explain", *words, "--out", tmp_path) == 0
    why = json.loads(capsys.readouterr().out)
    assert why["label"] == "chair"
    np.testing.assert_allclose(why["up_xyz"], turn.apply([0, 0, 1]), atol=0.02)


def test_a_floor_gives_a_hint_and_without_one_the_cloud_is_unchanged(chair, tmp_path, capsys):
    points, _ = on_floor("chair", 5, noise=0.003)
    np.save(tmp_path / "scan.npy", points)
    words = ("--out", tmp_path, "--near", 0, "--json")
    run("explain", tmp_path / "scan.npy", *words)
    out, err = capsys.readouterr()
    assert "scan.npy: seems to hold the floor, too; cut it off: --cut-floor" in err
    assert "floor" not in json.loads(out)
    run("explain", chair, "--cut-floor", *words)
    out, err = capsys.readouterr()
    assert "chair.ply: no floor found; nothing was cut off" in err
    assert "floor" not in json.loads(out)


def test_explain_any_way_up_gives_the_confidence_of_classify(tmp_path, capsys):
    """Whether another pose is close is part of the answer."""
    reasons = []
    for number, category in enumerate(("night_stand", "dresser", "monitor", "desk")):
        file = tmp_path / f"{category}.npy"
        np.save(file, make_furniture(category, number).sampled(4000, number).points_xyz)
        words = (file, "--up", "auto", "--json", "--threads", 1)
        run("classify", *words)
        run("explain", *words, "--out", tmp_path, "--near", 0)
        named, why = (json.loads(line) for line in capsys.readouterr().out.splitlines())
        reasons.append(named["reason"])
        assert (why["confident"], why["reason"]) == (named["confident"], named["reason"])
    assert any(reasons)


@pytest.mark.parametrize("command", ["explain", "classify"])
def test_no_floor_is_cut_off_a_grid(command, chair, tmp_path, capsys):
    run("grid", chair, "--out", tmp_path / "g.npz")
    capsys.readouterr()
    assert run(command, tmp_path / "g.npz", "--cut-floor") == 2
    printed = capsys.readouterr().err
    assert printed.endswith(
        "g.npz: is a grid, whose floor can not be removed; leave --cut-floor out\n"
    )


def test_a_grid_is_not_turned(chair, tmp_path, capsys):
    run("grid", chair, "--out", tmp_path / "g.npz")
    capsys.readouterr()
    assert run("explain", tmp_path / "g.npz", "--up", "y", "--out", tmp_path / "why") == 2
    printed = capsys.readouterr().err
    assert printed.endswith("g.npz: is a grid, which has its axis already; leave --up y out\n")
    assert not (tmp_path / "why").exists()


def test_of_many_near_objects_the_picture_names_a_dozen(chair, tmp_path, capsys, monkeypatch):
    from circumspect.evaluation import evidence_picture

    drawn, draw = [], evidence_picture.draw_evidence

    def kept(*given):
        drawn.append(draw(*given))
        return drawn[-1]

    monkeypatch.setattr(evidence_picture, "draw_evidence", kept)
    words = ("explain", chair, "--out", tmp_path, "--json", "--near", 100_000)
    assert run(*words, *MODELNET10) == 0
    nearest = json.loads(capsys.readouterr().out)["nearest"]
    assert len(nearest) > 1000
    labels = {axes.get_ylabel() for axes in drawn[0].axes}
    assert "height [file units]" in labels, "the unit is unknown"
    words = drawn[0].findobj(lambda one: "nearest training" in getattr(one, "get_text", str)())
    lines = words[0].get_text().splitlines()
    assert len(lines[lines.index("nearest training objects") + 1 :]) == 13
    assert lines[-1] == f"… and {len(nearest) - 12} more"


def test_a_saved_grid_and_another_label(chair, tmp_path, capsys):
    grid = tmp_path / "g.npz"
    cloud = read_cloud(chair)
    CylindricalGrid.fit(cloud).hits(cloud.points_xyz).save(grid)
    words = ("explain", grid, "--out", tmp_path, "--label", "sofa", "--near", 0)
    assert run(*words, *MODELNET10) == 0
    out = capsys.readouterr().out
    assert "evidence for sofa" in out
    assert "chair" in out
    assert "nearest training" not in out
    assert (tmp_path / "g-why.png").exists()


@pytest.mark.parametrize(
    ("flags", "complaint"),
    [
        (("--label", "stool"), "no class 'stool'"),
        (("--near", "-1"), "--near -1"),
        (("--examples", "none.npz"), "none.npz: does not exist"),
        (("--model", "none.onnx"), "no such file"),
    ],
)
def test_errors_are_one_line(chair, tmp_path, capsys, flags, complaint):
    assert run("explain", chair, "--out", tmp_path, *flags) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert complaint in err
    assert list(tmp_path.iterdir()) == []


def test_files_that_can_not_be_read(tmp_path, capsys):
    (tmp_path / "empty.off").write_bytes(b"")
    np.save(tmp_path / "line.npy", np.linspace(0, 1, 40)[:, None] * [1.0, 2, 3])
    RectangularGrid().hits(np.zeros((1, 3))).save(tmp_path / "box.npz")
    os.mkfifo(tmp_path / "pipe.npz")  # No process writes into the pipe.
    for name in ("empty.off", "line.npy", "gone.ply", "box.npz", "pipe.npz"):
        assert run("explain", tmp_path / name, "--out", tmp_path / "why") == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        assert name in err
    assert not (tmp_path / "why").exists()


def test_weights_without_a_table_are_explained_without_examples(chair, tmp_path, capsys):
    from circumspect.classification.shipped import shipped_path

    (tmp_path / "own.onnx").write_bytes(shipped_path("modelnet10").read_bytes())
    assert run("explain", chair, "--out", tmp_path, "--model", tmp_path / "own.onnx") == 0
    assert "export --examples" in capsys.readouterr().err


@pytest.mark.parametrize(
    "bounds",
    [CylindricalGrid((5, 7, 6), 2.0, 1.5, (1.0, 2.0, 3.0), 0.4), RectangularGrid((5, 4, 3), 2.0, (1.0, 0, 0), 0.3)],
)  # fmt: skip
def test_centres_lie_in_their_cells(bounds):
    states = (2 * (np.random.default_rng(0).random(bounds.shape) < 0.5)).astype(np.uint8)
    grid = OccupancyGrid(bounds, states)
    np.testing.assert_array_equal(
        bounds.indices(occupied_centres(grid)), np.argwhere(grid.occupied)
    )


def test_colours_are_symmetric_and_end_at_the_span():
    values = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    red, _, blue = evidence_colours(values, 1.0).T.astype(int)
    assert red[0] == red[1] < red[3] == red[4]
    assert blue[0] == blue[1] > blue[3] == blue[4]
    assert evidence_span(np.zeros(3)) == 1.0
    assert evidence_span(np.array([0.0, -4.0])) == 4.0


def test_colours_and_values_belong_to_points(tmp_path):
    cloud = PointCloud(np.eye(3))
    with pytest.raises(InputError, match="3 points"):
        write_coloured_ply(tmp_path / "x.ply", cloud, np.zeros((2, 3), np.uint8), np.zeros(3))


def test_half_of_the_evidence_of_one_cell_is_in_it():
    classifier = Classifier.load("modelnet10", threads=1)
    states = np.zeros((32, 32, 32), np.uint8)
    states[4, 3, 2] = 2
    found = explain_grid(classifier, OccupancyGrid(CylindricalGrid(), states))
    assert found.evidence.half_share in (0.0, 1.0)
    assert len(found.surface) == 1
