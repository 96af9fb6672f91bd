from __future__ import annotations

import json

import numpy as np
import pytest
from ceiling_world import MOUNT, camera, lens

from circumspect.errors import InputError
from circumspect.localization import (
    Calibration,
    Survey,
    SurveyedTag,
    read_calibration,
    read_survey,
    write_calibration,
    write_survey,
)


@pytest.fixture
def written(tmp_path):
    covariance = np.diag(np.arange(1.0, 7.0)) * 1e-6
    room = Calibration.of([camera(1.0, name="north", covariance=covariance)], MOUNT)
    room = room.with_lens("south", lens(focal=700.0), 0.21)
    write_calibration(tmp_path / "room.json", room)
    return tmp_path / "room.json"


def test_calibration_round_trip(written):
    room = read_calibration(written)
    assert room.mount == MOUNT
    assert room.without_pose == ("south",)
    assert room.lens("south") == lens(focal=700.0)
    assert room.lens_rms_px["south"] == 0.21
    (north,) = room.cameras
    expected = camera(1.0, name="north")
    np.testing.assert_allclose(
        north.T_map_camera.as_matrix(), expected.T_map_camera.as_matrix(), atol=1e-12
    )
    np.testing.assert_allclose(np.diag(north.covariance), np.arange(1.0, 7.0) * 1e-6)
    with pytest.raises(InputError, match=r"'east'; known: north, south.*intrinsics"):
        room.lens("east")


def test_a_new_lens_removes_the_pose(written):
    room = read_calibration(written).with_lens("north", lens(), 0.1)
    assert room.without_pose == ("north", "south")
    placed = room.with_place(camera(name="north"))
    assert placed.without_pose == ("south",)
    assert placed.lens_rms_px["north"] == 0.1


def broken(document, *path, value=None):
    *parents, last = path
    at = document
    for name in parents:
        at = at[name]
    if value is None:
        del at[last]
    else:
        at[last] = value


NORTH = ("cameras", "north")


@pytest.mark.parametrize(
    ("path", "value", "reason"),
    [
        (("cameras",), None, "needs an object 'cameras'"),
        (("cameras",), [], "needs an object 'cameras'"),
        (("tag_family",), "tag16h5", "tag16h5"),
        ((*NORTH, "K"), [[1, 0, 0], [0, 1, 0]], "camera 'north'.*'K'"),
        ((*NORTH, "K"), [[900, 1, 640], [0, 900, 480], [0, 0, 1]], "K must be"),
        ((*NORTH, "K"), [[-9, 0, 640], [0, 900, 480], [0, 0, 1]], "focal"),
        ((*NORTH, "width"), 640.5, "whole pixels"),
        ((*NORTH, "width"), "wide", "'width', has \"wide\""),
        ((*NORTH, "height"), None, "'height'; it has: width"),
        ((*NORTH, "distortion"), [0.1, 0.2], "5 finite numbers 'distortion'"),
        ((*NORTH, "distortion"), [-9, 0, 0, 0, 0], "folds"),
        ((*NORTH, "extrinsics", "quaternion_xyzw"), [0, 0, 0, 2], "unit length"),
        ((*NORTH, "extrinsics", "translation"), [0, 0, float("nan")], "translation"),
        ((*NORTH, "extrinsics", "translation"), [1e308, 0, 3], r"\(1e\+308, 0, 3\) m, too far away"),
        ((*NORTH, "extrinsics", "translation"), [0, 0, -1e9], "camera 'north'.*too far away"),
        ((*NORTH, "extrinsics", "covariance"), [[0.0] * 6] * 5, "covariance"),
        ((*NORTH, "extrinsics", "covariance"), (-np.eye(6)).tolist(), "covariance"),
        (("tag", "id"), 0.5, "integer"),
        (("tag", "id"), 600, "587|586"),
        (("tag", "id"), 10**400, "finite number 'id', has 1000"),
        ((*NORTH, "width"), 10**400, "finite number 'width'"),
        ((*NORTH, "distortion"), [10**400, 0, 0, 0, 0], "5 finite numbers 'distortion'"),
        (("tag", "size_m"), [0.1], "size_m"),
        (("tag", "height_m"), 1e308, "height"),
        (("tag", "x"), 1e9, "must be on the robot"),
        (("tag", "y"), -1e308, "must be on the robot"),
    ],
)  # fmt: skip
def test_broken_entries_are_named(written, path, value, reason):
    document = json.loads(written.read_text())
    broken(document, *path, value=value)
    written.write_text(json.dumps(document))
    with pytest.raises(InputError, match=reason) as error:
        read_calibration(written)
    assert str(error.value).startswith(f"{written}: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("text", ["", "{", "[]", "\x00\xff", '{"cameras": ' + "[" * 5000])
def test_invalid_files_are_refused(tmp_path, text):
    path = tmp_path / "room.json"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(InputError, match=r"room\.json"):
        read_calibration(path)


def test_a_missing_calibration_names_the_command(tmp_path):
    with pytest.raises(InputError, match="does not exist; calibrate with"):
        read_calibration(tmp_path / "room.json")
    with pytest.raises(InputError, match="can not be read"):
        read_survey(tmp_path / "survey.json")


def test_surveys_round_trip_and_broken_ones_are_refused(tmp_path):
    path = tmp_path / "survey.json"
    survey = Survey(0.16, {7: SurveyedTag(1.0, 2.0), 9: SurveyedTag(0.0, -1.0, 0.01, 0.5)}, 0.002)
    write_survey(path, survey)
    again = read_survey(path)
    assert again.tags[7] == SurveyedTag(1.0, 2.0)
    assert again.tags[9].yaw == pytest.approx(0.5)
    assert (again.size, again.position_sigma) == (0.16, 0.002)
    for tags, reason in (({}, "no tag"), ({"a": {}}, "numbers"), ({"7": {"x": 1}}, "'y'")):
        path.write_text(json.dumps({"tag_size_m": 0.16, "tags": tags}))
        with pytest.raises(InputError, match=reason):
            read_survey(path)
    huge = "9" * 5000
    for tags, reason in (
        ({huge: {"x": 1, "y": 2}}, "numbers, not '9{20}'$"),
        ({"7": {"x": 1, "y": 10**400}}, "finite number 'y'"),
        ({"7": {"x": 1, "y": 2e200}}, r"tag 7 is at \(1, 2e\+200, 0\) m, too far away"),
        ({"7": {"x": 1, "y": 2, "z": -1e9}}, "too far away"),
    ):
        path.write_text(json.dumps({"tag_size_m": 0.16, "tags": tags}))
        with pytest.raises(InputError, match=reason) as error:
            read_survey(path)
        assert str(error.value).startswith(f"{path}: ")
    path.write_text(json.dumps({"tag_size_m": 16, "tags": {"7": {"x": -177.7, "y": 35.5}}}))
    with pytest.raises(InputError, match=r"the tags' size is 16 m; give metres"):
        read_survey(path)
    path.write_text(json.dumps({"tag_size_m": 0, "tags": {"7": {"x": 1, "y": 2}}}))
    with pytest.raises(InputError, match="size"):
        read_survey(path)
