"""Packs of points round-trip, and faults of a pack are named."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_set import small_set

from circumspect.datasets import ObjectSet, open_data_set, validation_split
from circumspect.datasets.point_pack import read_point_pack, write_point_pack
from circumspect.errors import InputError


class TestPointPack:
    def test_round_trip_keeps_shape_up_to_quantisation(self, tmp_path):
        objects = small_set()
        write_point_pack(tmp_path / "train.npz", objects)
        back = open_data_set(tmp_path, "train")
        assert back.names.tolist() == objects.names.tolist()
        assert back.classes == objects.classes
        low = objects.points_xyz.min(axis=1, keepdims=True)
        side = np.ptp(objects.points_xyz, axis=1).max(axis=1)[:, None, None]
        np.testing.assert_allclose(back.points_xyz, (objects.points_xyz - low) / side, atol=1e-5)

    def test_broken_packs_are_named(self, tmp_path):
        path = tmp_path / "train.npz"
        write_point_pack(path, small_set())
        content = path.read_bytes()
        for broken in (b"", content[: len(content) // 2], b"not a zip"):
            path.write_bytes(broken)
            with pytest.raises(InputError, match=r"train\.npz"):
                read_point_pack(path)
        np.savez(path, labels=np.zeros(3))
        with pytest.raises(InputError, match="lacks points_u16"):
            read_point_pack(path)

    def test_an_object_without_a_shape_is_named(self, tmp_path):
        path = tmp_path / "train.npz"
        objects = small_set()
        objects.points_xyz[2] = 0.5
        write_point_pack(path, objects)
        with pytest.raises(InputError, match=r"train\.npz: bed_0002: all 20 points lie in one pl"):
            open_data_set(tmp_path, "train")

    def test_classes_in_rows_and_columns_are_refused(self, tmp_path):
        path = tmp_path / "train.npz"
        write_point_pack(path, small_set())
        arrays = dict(np.load(path))
        arrays["classes"] = arrays["classes"][:, None]
        np.savez(path, **arrays)
        with pytest.raises(InputError, match=r"classes must have shape \(c,\), not \(2, 1\)"):
            read_point_pack(path)

    @pytest.mark.parametrize(
        ("key", "dtype", "remedy"),
        [
            ("points_u16", "float64", "not of uint16; scale the coordinates to 0 … 65535"),
            ("points_u16", "int32", "not of uint16; scale the coordinates to 0 … 65535"),
            ("labels", "float32", "not of whole numbers; they count the classes from 0"),
            ("offset", "int64", "not of fractions; save offset.astype('float64')"),
            ("names", "object", "not of text; save numpy.array(names, dtype=str)"),
            ("classes", "|S5", "not of text; save numpy.array(classes, dtype=str)"),
        ],
    )
    def test_a_wrong_dtype_is_named_with_its_key_and_the_remedy(self, tmp_path, key, dtype, remedy):
        path = tmp_path / "train.npz"
        write_point_pack(path, small_set())
        arrays = dict(np.load(path))
        arrays[key] = arrays[key].astype(dtype)
        np.savez(path, **arrays)
        with pytest.raises(InputError) as error:
            read_point_pack(path)
        reported = f"{path}: {key} holds an array of {dtype}, {remedy}"
        assert str(error.value).startswith(reported)

    def test_points_of_another_shape(self, tmp_path):
        path = tmp_path / "train.npz"
        write_point_pack(path, small_set())
        arrays = dict(np.load(path))
        arrays["points_u16"] = arrays["points_u16"][0]
        np.savez(path, **arrays)
        with pytest.raises(
            InputError, match=r"points_u16 must have shape \(n, p, 3\), not \(20, 3"
        ):
            read_point_pack(path)

    @given(seed=st.integers(0, 2**32 - 1))
    def test_mutated_packs_give_a_set_or_a_known_error(self, tmp_path_factory, seed):
        path = tmp_path_factory.getbasetemp() / "mutated.npz"
        write_point_pack(path, small_set())
        rng = np.random.default_rng(seed)
        content = bytearray(path.read_bytes())
        for place in rng.integers(0, len(content), rng.integers(1, 6)):
            content[place] = rng.integers(256)
        path.write_bytes(content)
        with suppress(InputError):
            assert len(read_point_pack(path)) >= 0

    def test_a_single_test_pack_is_used_for_reports(self, tmp_path):
        write_point_pack(tmp_path / "test.npz", small_set())
        assert len(open_data_set(tmp_path / "test.npz", "test")) == 6
        for split in ("train", "validation", "fit"):
            with pytest.raises(InputError, match=r"test\.npz"):
                open_data_set(tmp_path / "test.npz", split)

    def test_a_single_training_pack_is_no_test_set(self, tmp_path):
        write_point_pack(tmp_path / "train.npz", small_set())
        assert len(open_data_set(tmp_path / "train.npz", "train")) == 6
        with pytest.raises(InputError, match="no test of anything"):
            open_data_set(tmp_path / "train.npz", "test")

    def test_objects_that_share_a_name_are_refused(self, tmp_path):
        """The training objects of a network are identified by name alone."""
        objects = small_set()
        objects.names[3] = objects.names[0]
        write_point_pack(tmp_path / "train.npz", objects)
        for path in (tmp_path, tmp_path / "train.npz"):
            with pytest.raises(InputError, match=r"train\.npz: 1 names .* as bed_0000 does"):
                open_data_set(path, "train")

    @pytest.mark.parametrize(("there", "asked"), [("train", "test"), ("test", "train")])
    def test_the_other_pack_is_missing(self, tmp_path, there, asked):
        write_point_pack(tmp_path / f"{there}.npz", small_set())
        with pytest.raises(InputError, match=rf"{asked}\.npz is missing, only {there}\.npz"):
            open_data_set(tmp_path, asked)

    def test_names_that_are_no_text_to_the_system(self, tmp_path):
        """As Python decodes file names whose bytes are no UTF-8."""
        objects = small_set(count=20)
        named = np.array([f"{name}\udcff" for name in objects.names])
        strange = ObjectSet(objects.points_xyz, objects.labels, named, objects.classes)
        write_point_pack(tmp_path / "train.npz", strange)
        back = open_data_set(tmp_path, "train")
        assert back.names.tolist() == named.tolist()
        assert (
            back.digest
            != ObjectSet(back.points_xyz, back.labels, objects.names, back.classes).digest
        )
        assert validation_split(back).any()

    def test_a_missing_set_is_refused(self, tmp_path):
        with pytest.raises(InputError, match="give point packs"):
            open_data_set(tmp_path / "nowhere", "train")
        with pytest.raises(InputError, match="no <class>/test"):
            open_data_set(tmp_path, "test")
