import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_set import small_set

from circumspect.classification.model_description import OBJECTS
from circumspect.datasets import GridCache, ObjectSet, open_data_set, validation_split
from circumspect.datasets.fitted_objects import fitted_objects
from circumspect.datasets.off_folder import object_name
from circumspect.datasets.point_pack import write_point_pack
from circumspect.datasets.validation_split import SHARE, near_duplicates
from circumspect.datasets.verification import MODELNET10, expected_names
from circumspect.errors import InputError


def families(points=300, seed=0):
    """Blocks of one class: families of two alike, each of other proportions, and a large one."""
    rng = np.random.default_rng(seed)
    members = [("large", i) for i in range(12)]
    members += [(f"family{k:02d}", i) for k in range(12) for i in range(2)]
    clouds, cube = [], rng.random((points, 3)) - 0.5
    for family, _ in members:
        k = 12 if family == "large" else int(family[-2:])
        size = [1.0, (0.05, 0.2, 0.45, 1.0)[k % 4], (0.1, 0.5, 1.2, 3.0)[k // 4]]
        clouds.append(cube * size + rng.normal(0, 0.002, cube.shape))
    names = np.array([f"{family}_{i}" for family, i in members])
    labels = np.zeros(len(members), np.int64)
    return ObjectSet(np.array(clouds, np.float32), labels, names, ("block",))


def scanned(objects, times):
    """Each object several times, from unknown starts."""
    rng = np.random.default_rng(0)
    clouds = []
    for cloud in np.tile(objects.points_xyz, (times, 1, 1)):
        turned = Rotation.from_rotvec([0, 0, rng.uniform(0, 2 * np.pi)]).apply(cloud)
        clouds.append(turned + rng.normal(0, 0.004, cloud.shape))
    names = [f"{name}@run{number}" for number in range(times) for name in objects.names]
    of = np.tile(objects.names, times)
    labels = np.tile(objects.labels, times)
    return ObjectSet(np.array(clouds, np.float32), labels, np.array(names), objects.classes, of)


class TestFittedObjects:
    def test_every_scan_of_a_fitted_object_is_known(self):
        scans = scanned(families(), times=2)
        first = scans.subset(np.arange(3))
        known = fitted_objects({OBJECTS: first.names.tolist()}, scans)
        assert scans.shown[known].tolist() == 2 * first.shown.tolist()
        later = scans.subset(np.arange(len(scans) // 2, len(scans)))
        assert fitted_objects({OBJECTS: first.names.tolist()}, later).sum() == 3

    def test_an_at_sign_in_names_of_other_sets_is_ignored(self):
        scans = scanned(families(), times=2)
        objects = replace(scans, scan_of=None)
        assert fitted_objects({OBJECTS: scans.names[:3].tolist()}, objects).sum() == 3

    def test_a_scanned_object_is_not_the_modelnet_object_of_that_name(self):
        scans = scanned(families(), times=2)
        assert not fitted_objects({OBJECTS: scans.shown.tolist()}, scans).any()


class TestObjectSet:
    @pytest.mark.parametrize(
        ("change", "complaint"),
        [
            ({"points_xyz": np.zeros((6, 20, 2), np.float32)}, "shape"),
            ({"labels": np.zeros(5, np.int64)}, "as many labels"),
            ({"labels": np.full(6, 7, np.int64)}, "outside"),
            ({"points_xyz": np.full((6, 20, 3), np.nan, np.float32)}, "NaN"),
            ({"scan_of": np.array(["bed"] * 5)}, "6 scans need as many objects"),
        ],
    )
    def test_arrays_of_different_lengths_are_refused(self, change, complaint):
        good = small_set()
        fields = {name: getattr(good, name) for name in ("points_xyz", "labels", "names")}
        with pytest.raises(InputError, match=complaint):
            ObjectSet(**{**fields, **change}, classes=good.classes)

    def test_digest_sees_every_part(self):
        digests = {small_set().digest, small_set(seed=1).digest, small_set(count=5).digest}
        assert len(digests) == 3
        assert small_set().digest == small_set().digest


class TestSplit:
    def test_near_duplicates_stay_together(self):
        objects = families()
        groups = near_duplicates(objects)
        family = np.array([name.rsplit("_", 1)[0] for name in objects.names])
        assert len(set(groups)) == len(set(family))
        for member in np.unique(family):
            assert len(set(groups[family == member])) == 1

    def test_whole_groups_are_held_back_and_large_ones_never(self):
        objects = families()
        held_back, groups = validation_split(objects), near_duplicates(objects)
        for group in np.unique(groups):
            assert len(set(held_back[groups == group])) == 1
        assert not held_back[[name.startswith("large") for name in objects.names]].any()
        assert SHARE <= held_back.mean() <= SHARE + 0.1

    def test_the_split_does_not_depend_on_the_order_and_changes_with_the_salt(self):
        objects = families()
        order = np.random.default_rng(0).permutation(len(objects))
        kept = validation_split(objects)
        assert (validation_split(objects.subset(order)) == kept[order]).all()
        assert (validation_split(objects, salt="1") != kept).any()

    def test_a_class_of_one_family_is_parted_object_by_object(self):
        objects = families()
        family = objects.subset(np.array([name.startswith("large") for name in objects.names]))
        assert 0 < validation_split(family).sum() < len(family) / 2

    def test_the_only_object_of_a_class_is_trained_on(self):
        objects = families()
        labels = np.where(np.arange(len(objects)) == 0, 1, 0)
        alone = ObjectSet(objects.points_xyz, labels, objects.names, ("many", "one"))
        held_back = validation_split(alone)
        assert held_back.any()
        assert not held_back[0]

    def test_scans_of_one_object_are_on_one_side_at_any_yaw(self):
        scans = scanned(families(), times=3)
        held_back = validation_split(scans)
        of_each = held_back.reshape(3, -1)
        assert (of_each == of_each[0]).all()
        assert SHARE <= held_back.mean() <= SHARE + 0.1
        shuffled = np.random.default_rng(0).permutation(len(scans))
        assert (validation_split(scans.subset(shuffled)) == held_back[shuffled]).all()

    def test_objects_scanned_once_are_split_as_before(self):
        once = scanned(families(), times=1)
        apart = replace(once, scan_of=None)
        assert (validation_split(once) == validation_split(apart)).all()
        assert once.digest == apart.digest

    def test_the_scans_of_the_only_object_of_a_class_are_trained_on(self):
        one = families().subset(np.array([0]))
        assert not validation_split(scanned(one, times=4)).any()

    def test_an_object_without_shape_is_named(self):
        flat = small_set()
        flat.points_xyz[2] = 0
        with pytest.raises(InputError, match=str(flat.names[2])):
            validation_split(flat)

    def test_fit_and_validation_part_the_training_split(self, tmp_path):
        write_point_pack(tmp_path / "train.npz", small_set(count=60))
        parts = [set(open_data_set(tmp_path, part).names) for part in ("fit", "validation")]
        assert not parts[0] & parts[1]
        assert parts[0] | parts[1] == set(open_data_set(tmp_path, "train").names)


def write_off(path, size):
    path.parent.mkdir(parents=True, exist_ok=True)
    corners = [(x, y, z) for x in (0, size) for y in (0, 1) for z in (0, 2)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    text = [f"OFF{len(corners)} {len(faces)} 0"]
    text += [" ".join(map(str, corner)) for corner in corners]
    text += ["4 " + " ".join(map(str, face)) for face in faces]
    path.write_text("\n".join(text) + "\n")


class TestOffFolder:
    def test_reads_the_usual_layout_and_caches_it(self, tmp_path):
        for name in ("bed", "chair"):
            for number in range(2):
                write_off(tmp_path / name / "train" / f"{name}_{number:04d}.off", 1 + number)
        progress = []
        objects = open_data_set(
            tmp_path, "train", lambda done, total: progress.append((done, total))
        )
        assert objects.classes == ("bed", "chair")
        assert objects.names.tolist() == ["bed_0000", "bed_0001", "chair_0000", "chair_0001"]
        assert objects.points_xyz.shape == (4, 1024, 3)
        assert progress[-1] == (4, 4)
        again = open_data_set(tmp_path, "train", lambda *_: pytest.fail("sampled twice"))
        assert again.digest == objects.digest

    def test_files_of_one_name_in_two_classes_are_two_objects(self, tmp_path):
        classes = ("night", "night_stand")
        for name in classes:
            for file in ("0001", "night_0001", "night_stand_0001"):
                write_off(tmp_path / name / "train" / f"{file}.off", 1.0)
        names = open_data_set(tmp_path, "train").names.tolist()
        assert len(set(names)) == 6
        assert names[:3] == ["night/train/0001", "night_0001", "night/train/night_stand_0001"]
        assert names[3:] == [
            "night_stand/train/0001",
            "night_stand/train/night_0001",
            "night_stand_0001",
        ]

    def test_splits_with_the_same_numbers_hold_other_objects(self, tmp_path):
        """Training objects keep their names; packs cached before are not used for these."""
        test = tmp_path / "mug" / "test"
        for number in (1, 2):
            write_off(test / f"mug_{number:04d}.off", number)
        before = open_data_set(tmp_path, "test")
        assert before.names.tolist() == ["mug_0001", "mug_0002"]
        write_off(tmp_path / "mug" / "train" / "mug_0001.off", 3.0)
        train, after = (open_data_set(tmp_path, split) for split in ("train", "test"))
        assert train.names.tolist() == ["mug_0001"]
        assert after.names.tolist() == ["mug/test/mug_0001", "mug_0002"]
        assert not fitted_objects({OBJECTS: train.names.tolist()}, after).any()

    def test_a_suffix_in_capitals_is_read_as_well(self, tmp_path):
        train, test = tmp_path / "mug" / "train", tmp_path / "mug" / "test"
        write_off(train / "mug_0001.OFF", 1.0)
        write_off(train / "mug_0002.off", 2.0)
        write_off(test / "mug_0001.off", 3.0)
        assert open_data_set(tmp_path, "train").names.tolist() == ["mug_0001", "mug_0002"]
        assert open_data_set(tmp_path, "test").names.tolist() == ["mug/test/mug_0001"]

    def test_two_files_that_would_be_one_object_are_refused(self, tmp_path):
        for suffix in ("off", "OFF"):
            write_off(tmp_path / "mug" / "train" / f"mug_0001.{suffix}", 1.0)
        if len(list((tmp_path / "mug" / "train").iterdir())) < 2:
            pytest.skip("this file system ignores case")
        with pytest.raises(
            InputError, match=r"mug_0001\.OFF and .*mug_0001\.off: one object in two"
        ):
            open_data_set(tmp_path, "train")

    def test_a_sofa_among_modelnet10s_chairs_is_reported(self, tmp_path, caplog):
        for name in MODELNET10:
            write_off(tmp_path / name / "test" / f"{name}_0901.off", 1.0)
        open_data_set(tmp_path, "test")
        assert caplog.messages == []
        for file in ("sofa_0701", "copy of a sofa"):
            write_off(tmp_path / "chair" / "test" / f"{file}.off", 2.0)
        for _ in range(2):
            caplog.clear()
            assert len(open_data_set(tmp_path, "test")) == 12
            assert caplog.messages == [
                f"{tmp_path}: 2 of 12 test files bear names foreign to their class folder, such as "
                "chair/test/copy of a sofa.off; "
                f"circumspect data verify {tmp_path} names them"
            ]

    def test_files_of_other_classes_may_have_any_name(self, tmp_path, caplog):
        write_off(tmp_path / "chair" / "test" / "mine.off", 1.0)
        open_data_set(tmp_path, "test")
        assert caplog.messages == []

    def test_modelnet10_is_named_after_its_files_alone(self):
        for split, names in expected_names().items():
            for name in names:
                file = Path(name.rpartition("_")[0], split, f"{name}.off")
                assert object_name(file) == name

    def test_file_names_that_are_no_text_are_read_and_cached(self, tmp_path):
        strange = tmp_path / "bed" / "train" / os.fsdecode(b"bed_\xff.off")
        try:
            write_off(strange, 1.0)
        except OSError:
            pytest.skip("this file system takes text alone")
        write_off(tmp_path / "bed" / "train" / "bed_0001.off", 2.0)
        objects = open_data_set(tmp_path, "train")
        assert objects.names.tolist() == ["bed_0001", strange.stem]
        again = open_data_set(tmp_path, "train", lambda *_: pytest.fail("sampled twice"))
        assert again.digest == objects.digest


class TestGridCache:
    def test_made_once_and_read_back(self, tmp_path):
        rng = np.random.default_rng(0)
        grids = (rng.random((5, 3, 4, 7)) < 0.3).astype(np.uint8)
        cache = GridCache(tmp_path)
        first = cache.get({"a": 1}, 5, (3, 4, 7), lambda: grids)
        second = cache.get({"a": 1}, 5, (3, 4, 7), lambda: pytest.fail("made twice"))
        np.testing.assert_array_equal(first[:], grids)
        np.testing.assert_array_equal(second[np.array([4, 1])], grids[[4, 1]])

    def test_another_key_is_another_entry(self, tmp_path):
        cache = GridCache(tmp_path)
        zeros, ones = np.zeros((2, 8), np.uint8), np.ones((2, 8), np.uint8)
        cache.get({"a": 1}, 2, (8,), lambda: zeros)
        np.testing.assert_array_equal(cache.get({"a": 2}, 2, (8,), lambda: ones)[:], ones)

    def test_a_broken_entry_is_made_again(self, tmp_path):
        cache = GridCache(tmp_path)
        ones = np.ones((2, 8), np.uint8)
        cache.get({}, 2, (8,), lambda: ones)
        (entry,) = tmp_path.glob("*.npy")
        entry.write_bytes(entry.read_bytes()[:50])
        np.testing.assert_array_equal(cache.get({}, 2, (8,), lambda: ones)[:], ones)
