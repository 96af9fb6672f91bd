from __future__ import annotations

import numpy as np
import pytest
from ceiling_world import camera

from circumspect.errors import InputError
from circumspect.localization import Survey, SurveyedTag, TagDetection, calibrate_lens
from circumspect.localization.charuco_board import CharucoBoard
from circumspect.localization.extrinsics_calibration import calibrate_extrinsics
from circumspect.localization.tag_mount import CORNERS

SIZE = 0.2


def laid(rng=None, yaw=True, spots=12):
    """A survey, and where its tags truly lie: (x, y, yaw)."""
    rng = rng or np.random.default_rng(0)
    places = [(-1.2 + 0.8 * (n % 4), -0.8 + 0.7 * (n // 4), 0.3 * n) for n in range(spots)]
    tags = {}
    for number, (x, y, turn) in enumerate(places, start=50):
        dx, dy = rng.normal(0, 0.001, 2)
        tags[number] = SurveyedTag(
            x + dx, y + dy, 0.0, turn + rng.normal(0, np.radians(0.5)) if yaw else None
        )
    return Survey(SIZE, tags), dict(zip(tags, places, strict=True))


def detections(one, places, sigma=0.06, rng=None):
    rng = rng or np.random.default_rng(1)
    found = []
    for number, (x, y, turn) in places.items():
        c, s = np.cos(turn), np.sin(turn)
        xy = SIZE * CORNERS @ np.array([[c, s], [-s, c]]) + [x, y]
        uv = one.project(np.column_stack([xy, np.zeros(4)]))
        found.append(TagDetection(number, uv + rng.normal(0, sigma, (4, 2)), 50.0, 0))
    return found


def off(found, true):
    return (true.T_map_camera.inv() * found.T_map_camera).as_exp_coords()


@pytest.mark.parametrize("yaw", [True, False])
def test_the_pose_is_recovered_within_its_covariance(yaw):
    squares = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        survey, places = laid(rng, yaw)
        true = camera(0.1, -0.1)
        found = calibrate_extrinsics("c", true.lens, [detections(true, places, rng=rng)], survey)
        error = off(found.camera, true)
        squares.append(error @ np.linalg.solve(found.camera.covariance, error))
        assert np.linalg.norm(error[3:]) < 0.01
        assert found.camera.rms_px < 0.12
    # Six degrees of freedom; standard deviation of the mean: sqrt(12 / 12) = 1.
    assert 3 < np.mean(squares) < 9.5


def test_wrong_and_hidden_tags_are_excluded():
    survey, places = laid()
    true = camera()
    tags = detections(true, places)
    wrong = {**places, 52: (places[52][0] + 0.05, *places[52][1:])}
    tags[2] = detections(true, wrong)[2]
    tags[5].corners_uv[1] += 6.0
    found = calibrate_extrinsics("c", true.lens, [tags], survey)
    assert set(found.left_out) == {52, 55}
    assert "from its surveyed position" in found.left_out[52]
    assert "partly hidden" in found.left_out[55]
    assert np.linalg.norm(off(found.camera, true)[3:]) < 0.01


def test_unsurveyed_and_repeated_tags_are_excluded():
    survey, places = laid()
    true = camera()
    tags = detections(true, places)
    strangers = [TagDetection(3, tags[0].corners_uv, 50.0, 0)] * 1
    found = calibrate_extrinsics("c", true.lens, [[*tags, tags[4], *strangers]], survey)
    assert 54 not in found.offsets_m
    assert found.left_out == {3: "it is not in the survey"}


def test_too_few_or_collinear_tags_are_refused():
    survey, places = laid()
    true = camera()
    tags = detections(true, places)
    with pytest.raises(InputError, match=r"'c' sees 2 surveyed tags, at least 3"):
        calibrate_extrinsics("c", true.lens, [tags[:2]], survey)
    row, nowhere = laid(yaw=False, spots=4)
    with pytest.raises(InputError, match="collinear"):
        calibrate_extrinsics("c", true.lens, [detections(true, nowhere)], row)
    other = Survey(0.4, survey.tags)
    with pytest.raises(InputError, match="do not fit the survey"):
        calibrate_extrinsics("c", true.lens, [tags], other)


def test_an_impossible_tag_size_is_refused():
    survey, places = laid()
    true = camera()
    with pytest.raises(InputError, match="the tags' size is 1e\\+200 m; give metres"):
        calibrate_extrinsics("c", true.lens, [detections(true, places)], Survey(1e200, survey.tags))


def test_lenses_need_images_of_the_board():
    grey = np.full((480, 640), 128, np.uint8)
    with pytest.raises(InputError, match="0 of 3 images show enough"):
        calibrate_lens([grey] * 3, CharucoBoard())
    with pytest.raises(InputError, match="different sizes: 600x480, 640x480"):
        calibrate_lens([grey, grey[:, :600]], CharucoBoard())
