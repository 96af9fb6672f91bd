"""`circumspect locate`: from images of boards and tags to a path, end to end."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from circumspect.cli.main import main
from circumspect.geometry import read_tum
from circumspect.localization import read_calibration

ROOT = Path(__file__).resolve().parents[2]


def run(*words):
    return main(["locate", *map(str, words)])


def printed_json(capsys):
    out, _ = capsys.readouterr()
    assert out.count("\n") == 1
    return json.loads(out)


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """Two cameras that look at a robot for two seconds."""
    folder = tmp_path_factory.mktemp("room")
    words = [
        "--cameras",
        "2",
        "--size",
        "800",
        "600",
        "--seconds",
        "1.6",
        "--rate",
        "5",
        "--seed",
        "1",
        "--json",
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        code = run("simulate", *words, "--images", folder / "images", "--out", folder / "run")
    assert code == 0
    return folder


def test_simulate_leaves_a_run(room):
    record = json.loads((room / "run" / "result.json").read_text())
    assert record["states"] == {"tracked": 8}
    assert record["error"]["position_rmse_m"] < 3e-3
    assert record["error"]["yaw_rmse_deg"] < 0.5
    assert 0 < record["space_error_m"] < 5e-3
    assert record["odometry_end_m"] < 0.1
    names = {file.name for file in (room / "run").iterdir()}
    assert names == {
        "calibration.json", "trajectory.txt", "truth.txt", "odometry.txt", "space.jsonl",
        "result.json", "space.png", "config.toml",
    }  # fmt: skip
    lines = (room / "run" / "space.jsonl").read_text().splitlines()
    assert len(lines) == 8
    first = json.loads(lines[0])
    assert first["cameras"]
    assert set(first["rejected"]) | set(first["cameras"]) == {"ceiling_0", "ceiling_1"}


def test_the_same_flags_from_the_file_of_a_run_give_the_same_run(room, tmp_path, capsys):
    out = tmp_path / "again"
    words = ("--config", room / "run" / "config.toml", "--images", tmp_path / "views", "--out", out)
    assert run("simulate", *words) == 0
    name = "trajectory.txt"
    assert (out / name).read_text() == (room / "run" / name).read_text()


def steps_of_the_page():
    """The commands of docs/ceiling-cameras.md for images, by subcommand."""
    lines = (ROOT / "docs" / "ceiling-cameras.md").read_text().splitlines()
    found = [line.split()[2:] for line in lines if re.match("circumspect locate .* images/", line)]
    return {words[0]: words for words in found}


def test_calibrate_and_track_from_the_images(room, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("images").symlink_to(room / "images")
    file, steps = tmp_path / "room.json", steps_of_the_page()
    for name in ("ceiling_0", "ceiling_1"):
        lens_words, place_words = (
            [word.replace("ceiling_0", name) for word in steps[step]]
            for step in ("intrinsics", "extrinsics")
        )
        assert run(*lens_words, "--json") == 0
        lens = printed_json(capsys)
        assert (lens["camera"], lens["rms_px"] < 0.3) == (name, True)
        assert run(*place_words, "--json") == 0
        place = printed_json(capsys)
        assert place["position_xyz"][2] == pytest.approx(3.0, abs=0.05)
        assert place["tags"] >= 8
    assert read_calibration(file).mount.height == 0.3
    out = tmp_path / "run"
    words = ("--truth", room / "run" / "truth.txt", "--out", out)
    assert run(*steps["track"], *words, "--json") == 0
    record = printed_json(capsys)
    assert record["states"] == {"tracked": 8}
    assert record["error"]["position_rmse_m"] < 5e-3
    assert len(read_tum(out / "trajectory.txt")) == 8
    assert (out / "space.png").stat().st_size > 10_000


def test_calibrating_one_camera_keeps_the_others(room, tmp_path, capsys):
    """Also where lenses come from a file of their own."""
    images, file, lenses = room / "images", tmp_path / "room.json", tmp_path / "lenses.json"
    document = json.loads((images / "calibration.json").read_text())
    del document["tag"]
    for camera in document["cameras"].values():
        del camera["extrinsics"]
    lenses.write_text(json.dumps(document))
    words = ("--survey", images / "survey.json", "--intrinsics", lenses, "--out", file)
    assert run("extrinsics", images / "floor" / "ceiling_0", *words, "--tag", 3, 0.2, 0.3) == 0
    marked = json.loads(file.read_text())
    marked["tag"] |= {"x": 0.25, "yaw_deg": 90.0}
    file.write_text(json.dumps(marked))
    first = read_calibration(file)
    assert run("extrinsics", images / "floor" / "ceiling_1", *words, "--tag", 4, 0.1, 0.4) == 0
    both = read_calibration(file)
    assert [camera.name for camera in both.cameras] == ["ceiling_0", "ceiling_1"]
    np.testing.assert_array_equal(
        both.cameras[0].T_map_camera.as_matrix(), first.cameras[0].T_map_camera.as_matrix()
    )
    assert (both.mount.tag_id, both.mount.size, both.mount.height) == (4, 0.1, 0.4)
    assert both.mount.T_base_tag == first.mount.T_base_tag
    assert both.mount.T_base_tag.x == 0.25
    capsys.readouterr()


def test_extrinsics_accept_intrinsics_of_another_program(room, tmp_path, capsys):
    """Without an image of our board: ROS's camera_calibration wrote the lens."""
    images = room / "images"
    known = json.loads((images / "calibration.json").read_text())["cameras"]["ceiling_0"]
    lens = tmp_path / "ros.yaml"
    lens.write_text(
        f"image_width: {known['width']}\nimage_height: {known['height']}\n"
        f"camera_matrix: {{rows: 3, cols: 3, data: {[v for row in known['K'] for v in row]}}}\n"
        "distortion_model: plumb_bob\n"
        f"distortion_coefficients: {{rows: 1, cols: 5, data: {known['distortion']}}}\n"
    )
    words = ("--survey", images / "survey.json", "--intrinsics", lens, "--json")
    assert run("extrinsics", images / "floor/ceiling_0", *words, "--out", tmp_path / "o.json") == 0
    place = printed_json(capsys)
    expected = known["extrinsics"]["translation"]
    np.testing.assert_allclose(place["position_xyz"], expected, atol=0.01)
    assert read_calibration(tmp_path / "o.json").lens("ceiling_0").distortion[0] != 0


def test_calibrate_and_track_print_sentences_without_json(room, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    images, file = room / "images", tmp_path / "room.json"
    board = images / "board" / "ceiling_0"
    assert run("intrinsics", board, "--out", file) == 0
    assert "Next: circumspect locate extrinsics" in capsys.readouterr().out
    words = ("--survey", images / "survey.json", "--intrinsics", file, "--out", file)
    assert run("extrinsics", images / "floor" / "ceiling_0", *words) == 0
    assert "Camera 'ceiling_0' hangs at" in capsys.readouterr().out
    calibration = ("--calibration", images / "calibration.json")
    broken = tmp_path / "track"
    shutil.copytree(images / "track", broken)
    next(iter(sorted((broken / "ceiling_0").iterdir()))).write_bytes(b"no image")
    odometry = room / "run" / "odometry.txt"
    assert run("track", broken, *calibration, "--odometry", odometry) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Located 8 of 8 times")
    assert "left out: " in err


@pytest.mark.parametrize("cameras", [("ceiling_0",), ("ceiling_0", "ceiling_1")])
def test_photos_far_apart_are_tracked(room, tmp_path, capsys, cameras):
    for name in cameras:
        folder = tmp_path / "photos" / name
        shutil.copytree(room / "images" / "track" / name, folder)
        images = sorted(folder.iterdir(), key=lambda path: float(path.stem))
        for n, image in enumerate(images):
            image.rename(folder / f"{15 * n}.000.png")
    out = tmp_path / "run"
    words = ("--calibration", room / "images/calibration.json", "--out", out, "--json")
    assert run("track", tmp_path / "photos", *words) == 0
    record = printed_json(capsys)
    assert record["states"].keys() <= {"tracked", "lost"}
    assert (record["times"], record["late"], record["clock_jumps"]) == (8, 0, 0)
    assert len(read_tum(out / "trajectory.txt")) == record["states"]["tracked"] >= 4


def test_boards_and_tags_are_printed(tmp_path, capsys):
    assert run("board", "--out", tmp_path, "--format", "png", "--json") == 0
    (page,) = printed_json(capsys)["pages"]
    with Image.open(page) as image:
        assert image.size == (3508, 2480)
    assert run("board", "--out", tmp_path, "--tags", 0, 7) == 0
    assert "tag-7.pdf" in capsys.readouterr().out
    assert {p.name for p in tmp_path.iterdir()} == {"board-9x6.png", "tag-0.pdf", "tag-7.pdf"}


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("track", "gone", "--calibration", "gone.json"), "gone.json: does not exist; calibrate"),
        (("track", "gone", "--calibration", "IMAGES/calibration.json"), "gone: is not a folder"),
        (("track", "IMAGES/track", "--calibration", "lens.json"), "knows no place of camera"),
        (("intrinsics", "IMAGES/floor/ceiling_0", "--out", "x.json"), "0 of 1 images show"),
        (
            ("intrinsics", "IMAGES/board/ceiling_0", "IMAGES/board/ceiling_1", "--out", "x.json"),
            "images from 2 folders, ceiling_0 and ceiling_1: a camera at a time",
        ),
        (("intrinsics", "gone.png", "--out", "x.json"), "gone.png: does not exist"),
        (
            ("extrinsics", "IMAGES/floor/ceiling_0", "--survey", "IMAGES/survey.json",
             "--intrinsics", "lens.json", "--camera", "east", "--out", "x.json"),
            "no intrinsics of camera 'east'",
        ),
        (
            ("extrinsics", "IMAGES/board/ceiling_0", "--survey", "IMAGES/survey.json",
             "--intrinsics", "lens.json", "--out", "x.json"),
            "sees 0 surveyed tags",
        ),
        (
            ("extrinsics", "IMAGES/floor/ceiling_0", "IMAGES/floor/ceiling_1", "--survey",
             "IMAGES/survey.json", "--intrinsics", "lens.json", "--out", "x.json"),
            "images from 2 folders, ceiling_0 and ceiling_1",
        ),
        (
            ("extrinsics", "IMAGES/floor/ceiling_0", "IMAGES/floor/ceiling_1", "--camera",
             "ceiling_0", "--survey", "IMAGES/survey.json", "--intrinsics", "lens.json",
             "--out", "x.json"),
            "do not fit the survey",
        ),
        (
            ("extrinsics", "half.png", "--camera", "ceiling_0", "--survey", "IMAGES/survey.json",
             "--intrinsics", "lens.json", "--out", "x.json"),
            "half.png: has 400x300 pixels, the lens was calibrated at 800x600",
        ),
        (
            ("track", "unreadable", "--calibration", "IMAGES/calibration.json"),
            "unreadable: no image can be read; the first: unreadable/ceiling_0/1.0.png: ",
        ),
        (
            ("track", "nanoseconds", "--calibration", "IMAGES/calibration.json"),
            "are these nanoseconds? Give seconds",
        ),
        (("simulate", "--images", "IMAGES"), "holds board already"),
        (("board", "--tags", "587"), "0 to 586"),
        (("board", "--square", "0"), "squares are from"),
        (("simulate", "--cameras", "0"), "--cameras 0"),
        (("simulate", "--images", "."), ".: holds survey.json already"),
        (("simulate", "--out", "."), "calibration.json: is of no such run and would be replaced"),
        (("simulate", "--out", "scanned"), "space.jsonl: is of no such run"),
        (
            ("track", "IMAGES/track", "--calibration", "IMAGES/calibration.json", "--out",
             "scanned"),
            "space.jsonl: is of no such run",
        ),
        (("simulate", "--ceiling", "inf"), "not inf m"),
        (("simulate", "--rate", "1000"), "--rate 1000"),
        (("simulate", "--speed", "9"), "9.0 m/s"),
        (("simulate", "--seed", "-1"), "--seed -1"),
        (("simulate", "--size", "1", "1"), "--size 1 1"),
        (("simulate", "--moved", "north", "--seed", "1"), "--moved north: no such camera"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(room, tmp_path, monkeypatch, capsys, words, complaint):
    monkeypatch.chdir(tmp_path)
    room_file = json.loads((room / "images" / "calibration.json").read_text())
    for camera in room_file["cameras"].values():
        del camera["extrinsics"]
    (tmp_path / "lens.json").write_text(json.dumps(room_file))
    Image.open(room / "images/floor/ceiling_0/00.png").resize((400, 300)).save("half.png")
    (tmp_path / "unreadable" / "ceiling_0").mkdir(parents=True)
    (tmp_path / "unreadable" / "ceiling_0" / "1.0.png").write_bytes(b"no picture")
    (tmp_path / "nanoseconds" / "ceiling_0").mkdir(parents=True)
    (tmp_path / "nanoseconds" / "ceiling_0" / "1690000000000000000.png").write_bytes(b"")
    (tmp_path / "scanned").mkdir()
    mine = [
        tmp_path / name
        for name in ("survey.json", "calibration.json", "scanned/log.jsonl", "scanned/space.jsonl")
    ]
    for file in mine:
        file.write_text("mine")
    assert run(*(word.replace("IMAGES", str(room / "images")) for word in words)) == 2
    out, err = capsys.readouterr()
    assert complaint in err
    assert err.count("\n") == err.count("circumspect: ")
    assert out == ""
    assert not (tmp_path / "x.json").exists()
    assert {file.read_text() for file in mine} == {"mine"}


@pytest.mark.parametrize(
    ("flags", "states"), [((), {"tracked": 8}), (("--tag", 7, 0.2, 0.3), {"lost": 8})]
)
def test_a_ground_truth_of_another_time_keeps_the_track(room, tmp_path, capsys, flags, states):
    lines = (room / "run" / "truth.txt").read_text().splitlines()
    later = [line.split() for line in lines if not line.startswith("#")]
    truth = tmp_path / "truth.txt"
    truth.write_text("".join(f"{float(s) + 1e3} {' '.join(rest)}\n" for s, *rest in later))
    words = ("track", room / "images" / "track", "--calibration", room / "images/calibration.json")
    out = tmp_path / "run"
    assert run(*words, *flags, "--truth", truth, "--out", out, "--json") == 0
    printed, stderr = capsys.readouterr()
    assert json.loads(printed)["error"] is None
    assert f"{truth}: no fix of the intelligent space has a true pose of its time" in stderr
    record = json.loads((out / "result.json").read_text())
    assert (record["states"], record["error"]) == (states, None)
    assert (out / "trajectory.txt").exists() is ("tracked" in states)


def test_a_track_without_fixes_gives_reasons_and_removes_the_old_trajectory(room, tmp_path, capsys):
    words = ("track", room / "images" / "track", "--calibration", room / "images/calibration.json")
    assert run(*words, "--out", tmp_path / "run") == 0
    assert (tmp_path / "run" / "trajectory.txt").exists()
    capsys.readouterr()
    assert run(*words, "--out", tmp_path / "run", "--tag", 7, 0.2, 0.3) == 0
    out, err = capsys.readouterr()
    assert "Located 0 of 8 times" in out
    assert "8 times ceiling_0: the tag is not in view (first: unknown tags are: 0)" in out
    assert "Warning" not in err
    assert not (tmp_path / "run" / "trajectory.txt").exists()


def test_a_tag_of_a_wrong_size_is_reported_before_one_out_of_view(room, tmp_path, capsys):
    words = ("track", room / "images" / "track", "--calibration", room / "images/calibration.json")
    assert run(*words, "--out", tmp_path / "run", "--tag", 0, 0.16, 0.31) == 0
    line = capsys.readouterr().out.splitlines()[1]
    misfits = r"\d+ times ceiling_\d: the corners are not those of a level tag of 0.16 m: blurred, "
    assert re.fullmatch(
        misfits + r"tilted or of another size \(first: squared residual \d+\)", line
    )
    assert int(line.split()[0]) > 1
    lines = (tmp_path / "run" / "space.jsonl").read_text().splitlines()
    reasons = [r for line in lines for r in json.loads(line)["rejected"].values()]
    assert len({r for r in reasons if "(squared residual " in r}) > 1


def test_an_unwritable_folder_is_refused_before_any_image_is_read(room, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    (tmp_path / "track" / "ceiling_0").mkdir(parents=True)
    (tmp_path / "track" / "ceiling_0" / "1.0.png").write_bytes(b"no picture")
    words = ("track", tmp_path / "track", "--calibration", room / "images/calibration.json")
    assert run(*words, "--out", tmp_path / "file" / "x") == 2
    complaint = capsys.readouterr().err
    assert str(tmp_path / "file" / "x") in complaint
    assert "image" not in complaint


def test_a_failed_call_keeps_the_earlier_run(room, capsys):
    before = {file.name: file.read_bytes() for file in (room / "run").iterdir() if file.is_file()}
    assert run("simulate", "--moved", "nobody", "--out", room / "run") == 2
    assert "nobody" in capsys.readouterr().err
    assert before == {
        file.name: file.read_bytes() for file in (room / "run").iterdir() if file.is_file()
    }


@pytest.mark.parametrize("name", ["simulate", "board", "intrinsics", "extrinsics", "track"])
def test_every_subcommand_explains_itself(name, capsys):
    with pytest.raises(SystemExit) as stop:
        run(name, "--help")
    assert stop.value.code == 0
    out = capsys.readouterr().out
    assert f"$ circumspect locate {name}" in out
    assert max(map(len, out.splitlines()[1:])) <= 80
