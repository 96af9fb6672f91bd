"""`circumspect data import sweethome3d`, as a user runs it."""

import json

import pytest
from sh3f_files import CHAIR, piece, write_sh3f

from circumspect.cli.main import main
from circumspect.datasets import read_mesh_pack
from circumspect.datasets.sweethome3d_classes import CLASSES


def run(*words):
    return main(["data", "import", *map(str, words)])


@pytest.fixture
def catalogues(tmp_path):
    folder = tmp_path / "catalogues"
    folder.mkdir()
    text = (
        piece(1) + piece(2, name="Bed", depth="200", width="140") + piece(3, name="Armchair")
        + piece(4, name="Wardrobe", height="200") + piece(5, name="Spoon", width="4", depth="20", height="2")
        + piece(6, model="/chair.dae") + piece(7, model=None) + piece(8, model="/bad.obj")
    )  # fmt: skip
    write_sh3f(folder / "One.sh3f", text, models={"folder/chair.obj": CHAIR, "bad.obj": "v 1"})
    write_sh3f(folder / "Two.sh3f", piece(width="60"), licence="CC0")
    return folder


def test_summary_and_pack(catalogues, tmp_path, capsys):
    out = tmp_path / "made" / "pack.npz"
    assert run("sweethome3d", catalogues, "--out", out) == 0
    printed = capsys.readouterr().out
    rows = dict(line.split()[:2] for line in printed.splitlines()[1:14])
    assert rows["chair"] == "2"
    assert (rows["bed"], rows["table"]) == ("1", "0")
    assert (rows["other"], rows["ambiguous"], rows["skipped"]) == ("2", "0", "4")
    assert "1 of the others have the size of furniture" in printed
    assert "skipped, its format .dae is not read: One 6 Chair" in printed
    assert "skipped, names no model: One 7 Chair" in printed
    assert "One: CC-BY 3.0 © Somebody (4 models)" in printed
    assert "Two: CC0 (1 models)" in printed
    meshes = read_mesh_pack(out)
    assert len(meshes) == 5
    assert {o.label for o in meshes.labelled} == {"chair", "bed"}
    assert [o.label for o in meshes.others] == ["other"]


def test_json(catalogues, tmp_path, capsys):
    out = tmp_path / "pack.npz"
    assert run("sweethome3d", catalogues, "--out", out, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["pack"] == str(out)
    assert document["bytes"] == out.stat().st_size
    assert document["models"] == 5
    assert document["classes"] == {**dict.fromkeys(CLASSES, 0), "chair": 2, "bed": 1}
    assert (document["others"], document["others_of_furniture_size"]) == (2, 1)
    assert [(piece["number"], piece["code"]) for piece in document["skipped"]] == [
        (3, "duplicate"), (6, "unread_format"), (7, "no_model"), (8, "broken_model"),
    ]  # fmt: skip
    assert document["catalogues"] == [
        {"catalogue": "One", "licence": "CC-BY 3.0 © Somebody", "models": 4},
        {"catalogue": "Two", "licence": "CC0", "models": 1},
    ]


def test_pack_is_called_sweethome3d_by_default(catalogues, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("SweetHome3D", catalogues / "Two.sh3f") == 0
    assert len(read_mesh_pack(tmp_path / "sweethome3d.npz")) == 1


def test_the_same_catalogues_give_the_same_meshes(catalogues, tmp_path):
    for name in ("a.npz", "b.npz"):
        assert run("sweethome3d", catalogues, "--out", tmp_path / name) == 0
    first, second = (read_mesh_pack(tmp_path / name) for name in ("a.npz", "b.npz"))
    assert first.names == second.names
    assert (first.vertices_u16 == second.vertices_u16).all()


def test_ctrl_c_leaves_no_files(catalogues, tmp_path, monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("circumspect.datasets.sweethome3d_import.placed_model", interrupted)
    out = tmp_path / "out" / "pack.npz"
    assert run("sweethome3d", catalogues, "--out", out) == 130
    assert "interrupted" in capsys.readouterr().err
    assert not list(out.parent.iterdir())


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["shapenet", "."], "no data set 'shapenet' to import; known: sweethome3d"),
        (["sweethome3d"], "needs a PATH"),
        (["sweethome3d", "."], "no .sh3f file"),
        (["sweethome3d", "nowhere"], "nowhere: does not exist"),
        (["sweethome3d", "bad.sh3f"], "bad.sh3f: is no readable zip"),
        (["sweethome3d", "empty.sh3f"], "list no furniture"),
        (["sweethome3d", "good.sh3f", "--url", "x"], "--url belongs to data fetch"),
        (["sweethome3d", "good.sh3f", "--out", "."], "is a folder"),
        (["sweethome3d", "good.sh3f", "--out", "bad.sh3f/pack.npz"], "can not be written"),
    ],
)
def test_errors_are_one_line(tmp_path, monkeypatch, capsys, words, reason):
    folder = tmp_path / "here"
    (folder / "none").mkdir(parents=True)
    (folder / "bad.sh3f").write_bytes(b"no zip")
    write_sh3f(folder / "empty.sh3f", "")
    write_sh3f(folder / "good.sh3f")
    monkeypatch.chdir(folder / "none" if words[1:] == ["."] else folder)
    assert run(*words) == 2
    captured = capsys.readouterr()
    assert reason in captured.err
    assert captured.err.count("\n") == 1
    assert not captured.out


@pytest.mark.parametrize("what", ["fetch", "verify"])
def test_only_import_takes_a_path(what, capsys):
    assert main(["data", what, "modelnet10", "elsewhere"]) == 2
    assert f"data {what} takes one SET and no further path" in capsys.readouterr().err
