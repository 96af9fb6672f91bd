"""Files of labelled real objects: what is read, and what is refused in one line."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_crops import arrays_of, write_crops

from circumspect.datasets import LabelledCrops, read_labelled_crops
from circumspect.datasets.labelled_crops import is_labelled_crops, read_crop_sources
from circumspect.errors import InputError

TEXT = st.text(
    st.characters(blacklist_categories=("Cs",), blacklist_characters="\0"), min_size=1, max_size=20
)


def small():
    rng = np.random.default_rng(0)
    clouds = [rng.random((count, 3)) for count in (5, 7, 3)]
    return arrays_of(clouds, ["chair", "table", "lamp"], ["kitchen", "kitchen", "hall"])


def refusal(path):
    with pytest.raises(InputError) as error:
        read_labelled_crops(path)
    message = str(error.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message


@given(
    counts=st.lists(st.integers(1, 9), min_size=1, max_size=6),
    words=st.lists(TEXT, min_size=12, max_size=12),
    double=st.booleans(),
    named=st.booleans(),
    offset_type=st.sampled_from(["int64", "int32", "uint16", ">i8"]),
)
def test_crops_round_trip(tmp_path_factory, counts, words, double, named, offset_type):
    rng = np.random.default_rng(0)
    clouds = [rng.normal(0, 3, (count, 3)) for count in counts]
    # NumPy drops zeros at the end of a text, hence the letter.
    labels = [word.strip() + "x" for word in words[: len(counts)]]
    scenes = [word + "x" for word in words[6 : 6 + len(counts)]]
    arrays = arrays_of(clouds, labels, scenes, frame=np.arange(len(counts)))
    arrays["offsets"] = arrays["offsets"].astype(offset_type)
    if double:
        arrays["points"] = np.concatenate(clouds)
    if named:
        arrays["name"] = np.array([f"piece {k}" for k in range(len(counts))])
    path = tmp_path_factory.getbasetemp() / "crops.npz"
    np.savez(path, **arrays)
    assert is_labelled_crops(path)
    crops = read_labelled_crops(path)
    assert len(crops) == len(counts)
    assert crops.labels.tolist() == labels
    assert crops.scenes.tolist() == scenes
    assert crops.names[0] == ("piece 0" if named else "0000")
    for index, cloud in enumerate(clouds):
        read = crops.cloud(index).points_xyz
        np.testing.assert_allclose(read, cloud, rtol=0 if double else 1e-6, atol=1e-6)


def test_arrays_are_read_only(tmp_path):
    crops = read_labelled_crops(write_crops(tmp_path / "a.npz", small()))
    with pytest.raises(ValueError, match="read-only"):
        crops.points_xyz[0] = 0.0


def test_digest_depends_on_points_labels_and_scenes(tmp_path):
    first = read_labelled_crops(write_crops(tmp_path / "a.npz", small())).digest
    assert read_labelled_crops(write_crops(tmp_path / "b.npz", small())).digest == first
    for key, value in (("label", "bed"), ("scene", "attic"), ("points", 0.125)):
        arrays = small()
        arrays[key] = arrays[key].copy()
        arrays[key][1] = value
        assert read_labelled_crops(write_crops(tmp_path / "c.npz", arrays)).digest != first


@pytest.mark.parametrize("key", ["points", "offsets", "label", "scene"])
def test_a_missing_key_is_named(tmp_path, key):
    arrays = small()
    del arrays[key]
    path = write_crops(tmp_path / "crops.npz", arrays)
    assert is_labelled_crops(path), "so that the fault is not that of another layout"
    assert f"lacks {key}" in refusal(path)


def test_files_of_another_layout_are_no_crops(tmp_path):
    np.savez(tmp_path / "pack.npz", points_u16=np.zeros((1, 4, 3), np.uint16), labels=[0])
    np.savez(tmp_path / "cloud.npz", points_xyz=np.zeros((4, 3)))
    (tmp_path / "text.npz").write_text("no zip")
    for name in ("pack.npz", "cloud.npz", "text.npz", "missing.npz", "."):
        assert not is_labelled_crops(tmp_path / name)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"points": np.zeros((15, 2), "f4")}, "points must have shape (n, 3), not (15, 2)"),
        ({"points": np.zeros(15, "f4")}, "points must have shape (n, 3), not (15,)"),
        ({"points": np.zeros((15, 3), int)}, "points holds an array of int64, not of fractions"),
        ({"points": np.zeros((15, 3), complex)}, "points holds an array of complex128"),
        ({"offsets": np.array([0.0, 5, 12, 15])}, "offsets holds an array of float64, not of whole"),
        ({"offsets": np.array([0, 5, 15])}, "3 labels need 4 offsets"),
        ({"offsets": np.array(3)}, "3 labels need 4 offsets"),
        ({"offsets": np.array([0, 5, 12, 16])}, "offsets must go from 0 to 15"),
        ({"offsets": np.array([1, 5, 12, 15])}, "offsets must go from 0 to 15"),
        ({"offsets": np.array([0, 12, 5, 15])}, "offsets must ascend; offset 2 is 5, less than 12"),
        ({"offsets": np.array([0, 2**64 - 1, 5, 15], np.uint64)}, "more than any file has points"),
        ({"offsets": np.array([0, 5, 5, 15])}, "object 1 (table in kitchen) has no points"),
        ({"label": np.array([], str), "scene": np.array([], str), "offsets": np.array([0])},
         "holds one object at least"),
        ({"label": np.array([1, 2, 3])}, "label holds an array of int64, not of text; save numpy"),
        ({"label": np.array([b"a", b"b", b"c"])}, "label holds an array of |S1, not of text"),
        ({"label": np.array(["a", "b", "c"], object)}, "label holds an array of object, not of te"),
        ({"label": np.array("chair")}, "label must have shape (k,), not ()"),
        ({"label": np.array([["a"], ["b"], ["c"]])}, "label must have shape (k,), not (3, 1)"),
        ({"label": np.array(["chair", " ", "lamp"])}, "object 1 has no label; write 'unknown'"),
        ({"label": np.array(["chair", "x" * 999, "lamp"])}, "label of object 1 has 999 characters"),
        ({"scene": np.array(["kitchen"])}, "3 labels need as many of scene, not (1,)"),
        ({"name": np.array(["a", "b"])}, "3 labels need as many of name, not (2,)"),
        ({"name": np.array([1, 2, 3])}, "name holds an array of int64, not of text"),
    ],
)  # fmt: skip
def test_arrays_that_do_not_fit_are_refused(tmp_path, changes, why):
    assert why in refusal(write_crops(tmp_path / "crops.npz", {**small(), **changes}))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_points_that_are_not_finite_are_counted_for_their_object(tmp_path, value):
    arrays = small()
    arrays["points"][[6, 8, 13]] = value
    message = refusal(write_crops(tmp_path / "crops.npz", arrays))
    assert "object 1 (table in kitchen) has 2 points that are NaN or infinite" in message


def test_truncated_files_are_refused(tmp_path):
    path = write_crops(tmp_path / "crops.npz", small())
    content = path.read_bytes()
    for length in (0, 10, len(content) // 2, len(content) - 5):
        path.write_bytes(content[:length])
        refusal(path)


def test_missing_files_and_folders_are_refused(tmp_path):
    assert "does not exist" in refusal(tmp_path / "none.npz")
    assert "is a folder" in refusal(tmp_path)


@given(seed=st.integers(0, 2**32 - 1))
def test_mutated_files_give_crops_or_a_known_error(tmp_path_factory, seed):
    path = write_crops(tmp_path_factory.getbasetemp() / "mutated.npz", small())
    rng = np.random.default_rng(seed)
    content = bytearray(path.read_bytes())
    for place in rng.integers(0, len(content), rng.integers(1, 6)):
        content[place] = rng.integers(256)
    path.write_bytes(content)
    is_labelled_crops(path)
    with suppress(InputError):
        assert len(read_labelled_crops(path)) >= 1


def test_messages_hold_no_control_characters(tmp_path):
    arrays = small()
    arrays["label"] = np.array(["chair", "a\x1b[2Jb\nc", "lamp"])
    arrays["offsets"] = np.array([0, 5, 5, 15])
    assert "\x1b" not in refusal(write_crops(tmp_path / "crops.npz", arrays))


class TestSeveralFiles:
    def test_files_are_named_after_themselves(self, tmp_path):
        for name in ("a", "b"):
            write_crops(tmp_path / f"{name}.npz", small())
        found = read_crop_sources([tmp_path / "b.npz", tmp_path / "a.npz"])
        assert list(found) == ["b", "a"]

    def test_files_of_one_name_are_named_after_their_folders_as_well(self, tmp_path):
        paths = [tmp_path / name / "deep" / "objects.npz" for name in ("one", "two")]
        for path in paths:
            path.parent.mkdir(parents=True)
            write_crops(path, small())
        assert list(read_crop_sources(paths)) == ["one/deep/objects", "two/deep/objects"]

    def test_a_repeated_file_is_refused(self, tmp_path):
        path = write_crops(tmp_path / "a.npz", small())
        with pytest.raises(InputError, match="given more than once"):
            read_crop_sources([path, tmp_path / "." / "a.npz"])

    def test_no_file_is_refused(self):
        with pytest.raises(InputError, match="no file of labelled objects"):
            read_crop_sources([])


@pytest.mark.parametrize(
    ("file", "objects", "scenes"),
    [
        ("sun3d_mit/objects.npz", 66, 4),
        ("real_crops/sunrgbd.npz", 30, 14),
        ("real_crops/scannet.npz", 17, 3),
    ],
)
def test_development_sets_are_read(data_folder: Path, file, objects, scenes):
    if not (data_folder / file).is_file():
        pytest.skip(f"no {file} in the development data")
    crops = read_labelled_crops(data_folder / file)
    assert isinstance(crops, LabelledCrops)
    assert len(crops) == objects
    assert len(set(crops.scenes.tolist())) == scenes
    sides = [np.ptp(crops.cloud(index).points_xyz, axis=0).max() for index in range(objects)]
    assert 0.2 < min(sides) < max(sides) < 10.0, "metres"
