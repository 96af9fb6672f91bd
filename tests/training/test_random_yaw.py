"""Training at random yaw: what is turned, and that nothing changes without it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from quick_run import QUICK, Silent, as_meant, run
from two_kinds import BEAMS_AND_BOARDS, two_kinds

from circumspect.classification import GridSpec, PointsSpec
from circumspect.datasets import Augmentation, GridCache
from circumspect.datasets.augmented_clouds import TRIANGLES, AugmentedClouds, AugmentedGrids
from circumspect.datasets.grid_cache import FORMAT
from circumspect.errors import InputError
from circumspect.grid import hits_batch
from circumspect.nets.registry import NETS, net_spec, require_turnable
from circumspect.training import TrainingSettings
from circumspect.training.run_config import CONFIG, config_differences
from circumspect.training.training_data import YAWS, YAWS_AROUND, examined_yaws

TURNED = replace(QUICK, random_yaw=True)


def variants(random_yaw, changes=None, seed=0):
    return AugmentedClouds(two_kinds(6), changes or Augmentation(), seed, True, random_yaw)


def angle_between(still, turned):
    """The rotation [rad] of all points about the z axis."""
    np.testing.assert_array_equal(turned[:, 2], still[:, 2])
    flat, other = (points[:, 0] + 1j * points[:, 1] for points in (still, turned))
    angle = np.angle((other * flat.conj()).sum())
    np.testing.assert_allclose(other, flat * np.exp(1j * angle), atol=1e-6)
    return angle


@given(seed=st.integers(0, 2**20), index=st.integers(0, 5), replica=st.integers(0, 30))
def test_each_variant_is_a_rotation_of_the_one_without_random_yaw(seed, index, replica):
    still, turned = (variants(on, seed=seed).samples(index, replica) for on in (False, True))
    angle_between(still.astype(np.float64), turned.astype(np.float64))


def test_each_variant_has_its_own_angle_of_the_whole_circle():
    still, turned = variants(False, Augmentation.none()), variants(True, Augmentation.none())
    angles = np.array(
        [
            angle_between(*(clouds.samples(i, r).astype(np.float64) for clouds in (still, turned)))
            for i in range(6)
            for r in range(30)
        ]
    )
    assert len(np.unique(angles.round(6))) == 180
    # Of uniform angles the mean direction is shorter than this in all but one of 10^6 cases.
    assert abs(np.exp(1j * angles).mean()) < np.sqrt(14 / 180)


def test_points_are_turned_before_they_are_gridded(tmp_path):
    clouds, input_spec = variants(True), GridSpec("rectangular", margin=1.1)
    made = AugmentedGrids(clouds, input_spec, 2, GridCache(tmp_path))
    for replica in range(2):
        grid = made.batch(np.array([3]), np.array([replica]))[0, 0]
        samples = clouds.samples(3, replica)
        np.testing.assert_array_equal(grid, hits_batch([input_spec.unit_bounds], [samples])[0])


def test_the_cache_names_a_random_yaw_only_where_there_is_one(tmp_path):
    """Without random yaw the cache key is that of versions without the setting."""
    clouds, input_spec = variants(False), GridSpec()
    changes = asdict(clouds.augmentation)
    del changes["damage"]
    filling = input_spec.to_dict()
    del filling["margin"], filling["dithered"]
    key = {
        "format": FORMAT, "count": 6, "shape": input_spec.shape, "objects": clouds.objects.digest,
        "recipe": filling, "augmentation": changes, "triangles": TRIANGLES, "seed": 0, "replica": 0,
    }  # fmt: skip
    name = hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:40]
    AugmentedGrids(clouds, input_spec, 1, GridCache(tmp_path))
    assert [path.stem for path in tmp_path.iterdir()] == [name]
    AugmentedGrids(variants(True), input_spec, 1, GridCache(tmp_path))
    assert len(list(tmp_path.iterdir())) == 2


def test_older_settings_have_no_random_yaw():
    asked = json.loads(json.dumps({"settings": TURNED.to_dict(), "data": "x"}))
    stored = json.loads(json.dumps({"settings": QUICK.to_dict(), "data": "x"}))
    del stored["settings"]["random_yaw"]
    assert config_differences(stored, asked) == "settings.random_yaw (false, not true)"
    asked["settings"]["random_yaw"] = False
    assert config_differences(stored, asked) == ""


def test_points_that_were_stored_in_no_order_are_the_same_input_spec():
    asked = {"settings": QUICK.to_dict(), "grid": PointsSpec(128).to_dict(), "data": "x"}
    asked = json.loads(json.dumps(asked))
    stored = json.loads(json.dumps(asked))
    del stored["grid"]["farthest_first"]
    assert config_differences(stored, asked) == ""
    asked["grid"]["farthest_first"] = True
    assert config_differences(stored, asked) == "grid.farthest_first (false, not true)"


def test_an_older_run_resumes_without_random_yaw(tmp_path):
    folder = tmp_path / "run"
    run(folder, stop_after=1)
    config = json.loads((folder / CONFIG).read_text())
    del config["settings"]["random_yaw"]
    (folder / CONFIG).write_text(json.dumps(config))
    with pytest.raises(InputError, match=r"other settings\.random_yaw \(false, not true\)"):
        run(folder, TURNED)
    assert run(folder).training["settings"]["random_yaw"] is False


def test_a_run_at_random_yaw_records_it_and_learns(tmp_path):
    objects = two_kinds(96, classes=("beam", "board"), sizes=BEAMS_AND_BOARDS)
    settings = as_meant("pointnet", epochs=8, replicas=8, random_yaw=True)
    checkpoint = run(tmp_path / "run", settings, objects, input_spec=PointsSpec(128))
    assert checkpoint.training["settings"]["random_yaw"] is True
    assert checkpoint.training["reached"]["validation_accuracy"] == 1.0


def test_validation_uses_all_yaws_only_with_random_yaw():
    assert examined_yaws(random_yaw=False) == YAWS
    assert examined_yaws(random_yaw=True) == YAWS_AROUND
    assert len(YAWS) == len(YAWS_AROUND)
    gaps = np.diff([*YAWS_AROUND, 2 * np.pi])
    assert np.degrees(gaps).max() < 125


def test_a_network_that_learns_where_objects_face_is_not_turned(tmp_path):
    settings = replace(TURNED, net="headed-planes")
    with pytest.raises(InputError, match="headed-planes learns which way objects face"):
        run(tmp_path / "run", settings)
    assert not (tmp_path / "run").exists()
    headed = {name for name, spec in NETS.items() if spec.heading}
    assert headed == {"headed-planes"}
    for name in NETS.keys() - headed:
        require_turnable(name)


def test_one_variant_of_each_object_is_too_few_for_a_random_yaw():
    with pytest.raises(InputError, match=r"--random-yaw turns .* give --replicas 2 or more"):
        TrainingSettings(replicas=1, random_yaw=True)


def test_no_default_settings_use_random_yaw():
    assert not TrainingSettings().random_yaw
    assert not any("random_yaw" in net_spec(name).training for name in NETS)


def test_preparing_is_reported_as_without_it(tmp_path):
    calls = []

    class Noting(Silent):
        def preparing(self, done, total):
            calls.append((done, total))

    run(tmp_path / "run", replace(TURNED, epochs=1), observer=Noting())
    assert calls == [(1, 2), (2, 2)]
