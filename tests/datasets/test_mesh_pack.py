"""Mesh packs: round trips, unique names, and every kind of broken file."""

import pickle
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets.mesh_pack import (
    AMBIGUOUS,
    OTHER,
    MeshEntry,
    read_mesh_pack,
    write_mesh_pack,
)
from circumspect.datasets.packed_mesh import PackedMesh
from circumspect.errors import GeometryError, InputError, OutputError
from circumspect.geometry import TriangleMesh

CLASSES = ("bed", "chair")
TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=8)


def random_mesh(seed=0, vertices=12, faces=20):
    rng = np.random.default_rng(seed)
    return TriangleMesh(
        rng.normal(size=(vertices, 3)) * rng.uniform(1e-3, 1e3) + rng.normal(size=3),
        np.stack([rng.permutation(vertices)[:3] for _ in range(faces)]),
    )


def entry(seed=0, label=1, **changes):
    record = {"title": "Chair", "catalogue": "c", "model_id": f"m{seed}", **changes}
    return MeshEntry(
        PackedMesh.from_mesh(random_mesh(seed)), label, (0.5, 0.6, 0.9),
        record.pop("furniture_size", True), **record,
    )  # fmt: skip


@pytest.fixture
def pack(tmp_path):
    path = tmp_path / "pack.npz"
    labels = (1, OTHER, AMBIGUOUS, 0, OTHER)
    entries = [entry(i, label, furniture_size=i != 4) for i, label in enumerate(labels)]
    write_mesh_pack(path, entries, CLASSES)
    return path


def changed(path, **arrays):
    """The same pack with some arrays changed or, if None, left out."""
    pack = {**np.load(path), **arrays}
    np.savez(path, **{key: array for key, array in pack.items() if array is not None})
    return path


class TestPackedMesh:
    @given(seed=st.integers(0, 2**32 - 1))
    def test_vertices_move_by_half_a_step_at_most(self, seed):
        mesh = random_mesh(seed)
        packed = PackedMesh.from_mesh(mesh)
        distances = np.abs(
            mesh.vertices_xyz[mesh.faces.ravel()][:, None] - packed.mesh().vertices_xyz
        )
        step = packed.scale / 65535
        assert distances.max(axis=2).min(axis=1).max() <= 0.5 * step * (1 + 1e-6)

    @given(seed=st.integers(0, 2**32 - 1))
    def test_packing_again_changes_nothing(self, seed):
        packed = PackedMesh.from_mesh(random_mesh(seed))
        again = PackedMesh.from_mesh(packed.mesh())
        np.testing.assert_array_equal(again.vertices_u16, packed.vertices_u16)
        np.testing.assert_array_equal(again.faces, packed.faces)

    def test_equal_vertices_become_one_and_unused_ones_are_dropped(self):
        vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [9, 9, 9]]
        packed = PackedMesh.from_mesh(TriangleMesh(vertices, [[0, 1, 2], [3, 5, 4], [1, 3, 5]]))
        assert len(packed.vertices_u16) == 4
        assert len(packed.faces) == 2
        assert packed.scale == 1

    def test_many_vertices_need_wider_faces(self):
        side = 260
        x, y = np.meshgrid(np.arange(side), np.arange(side))
        vertices = np.stack([x.ravel(), y.ravel(), np.zeros(side**2)], axis=1)
        first = (x[:-1, :-1] + side * y[:-1, :-1]).ravel()
        faces = np.stack([first, first + 1, first + side + 1], axis=1)
        packed = PackedMesh.from_mesh(TriangleMesh(vertices, faces))
        assert packed.faces.dtype == np.uint32
        assert packed.faces.max() == len(packed.vertices_u16) - 1 > 65535

    @pytest.mark.parametrize(
        ("vertices", "reason"),
        [
            (np.ones((3, 3)), "no extent"),
            ([[0, 0, 0], [1e-9, 0, 0], [0, 1e-9, 0], [1, 1, 1]], "no triangle is larger"),
        ],
    )
    def test_mesh_without_surface_is_refused(self, vertices, reason):
        faces = [[0, 1, 2]] if len(vertices) == 3 else [[0, 1, 2], [3, 3, 3]]
        with pytest.raises(GeometryError, match=reason):
            PackedMesh.from_mesh(TriangleMesh(vertices, faces))


class TestRoundTrip:
    @given(
        records=st.lists(
            st.tuples(st.integers(AMBIGUOUS, 1), st.booleans(), TEXT, TEXT, TEXT, TEXT, TEXT, TEXT),
            min_size=1, max_size=5,
        )
    )  # fmt: skip
    def test_meshes_round_trip(self, tmp_path_factory, records):
        path = tmp_path_factory.getbasetemp() / "round_trip.npz"
        entries = [
            MeshEntry(PackedMesh.from_mesh(random_mesh(i)), label, (1.0, 0.5, 2.0), size, *texts)
            for i, (label, size, *texts) in enumerate(records)
        ]
        write_mesh_pack(path, entries, CLASSES)
        back = read_mesh_pack(path)
        assert len(back) == len(entries)
        assert back.classes == CLASSES
        assert len(set(back.names)) == len(entries)
        for index, given_entry in enumerate(entries):
            read = back.entry(index)
            assert {**vars(read), "packed": None} == {**vars(given_entry), "packed": None}
            np.testing.assert_array_equal(
                read.packed.mesh().vertices_xyz, given_entry.packed.mesh().vertices_xyz
            )
            np.testing.assert_array_equal(read.packed.mesh().faces, given_entry.packed.mesh().faces)

    def test_labelled_and_other_objects(self, pack):
        meshes = read_mesh_pack(pack)
        assert [(o.name, o.label) for o in meshes.labelled] == [("c/m0", "chair"), ("c/m3", "bed")]
        assert [(o.name, o.label) for o in meshes.others] == [("c/m1", "other")]
        np.testing.assert_array_equal(
            meshes.labelled[1].mesh.vertices_xyz, meshes.mesh(3).vertices_xyz
        )

    def test_names_are_unique_where_paths_are_shared(self, tmp_path):
        ids = ["a", "a", "a#2", "a", "b"]
        entries = [entry(i, model_id=model_id) for i, model_id in enumerate(ids)]
        write_mesh_pack(tmp_path / "p.npz", entries, CLASSES)
        names = read_mesh_pack(tmp_path / "p.npz").names
        assert names == ("c/a", "c/a#3", "c/a#2", "c/a#4", "c/b")

    def test_meshes_beyond_the_set_do_not_exist(self, pack):
        meshes = read_mesh_pack(pack)
        for index in (-1, 5):
            with pytest.raises(IndexError):
                meshes.mesh(index)

    def test_sets_and_objects_can_be_pickled_and_stay_read_only(self, pack):
        meshes = read_mesh_pack(pack)
        whole = pickle.loads(pickle.dumps(meshes))
        assert whole.names == meshes.names
        assert not whole.faces.flags.writeable
        one = pickle.dumps(meshes.labelled[0])
        assert len(one) < len(pickle.dumps(meshes)) / 2
        assert pickle.loads(one).mesh.faces.shape == meshes.labelled[0].mesh.faces.shape

    def test_large_meshes_share_a_pack_with_small_ones(self, tmp_path):
        wide = entry(1)
        wide = MeshEntry(
            PackedMesh(np.zeros((65537, 3), np.uint16), np.array([[0, 1, 65536]], np.uint32), np.zeros(3), 1.0),
            0, (1.0, 1.0, 1.0), True, "Bed",
        )  # fmt: skip
        write_mesh_pack(tmp_path / "p.npz", [entry(0), wide], CLASSES)
        meshes = read_mesh_pack(tmp_path / "p.npz")
        assert meshes.mesh(1).faces.tolist() == [[0, 1, 65536]]
        np.testing.assert_array_equal(meshes.mesh(0).faces, entry(0).packed.mesh().faces)


class TestRefusals:
    def test_broken_and_truncated_files(self, pack):
        whole = pack.read_bytes()
        for broken in (b"", whole[: len(whole) // 2], whole[:-30], b"not a zip"):
            pack.write_bytes(broken)
            with pytest.raises(InputError, match=r"pack\.npz: ") as error:
                read_mesh_pack(pack)
            assert "\n" not in str(error.value)

    def test_missing_file(self, tmp_path):
        with pytest.raises(InputError, match=r"nowhere\.npz: does not exist"):
            read_mesh_pack(tmp_path / "nowhere.npz")

    @pytest.mark.parametrize("key", ["verts_u16", "voff", "name", "class10", "classes", "dims"])
    def test_missing_key_is_named(self, pack, key):
        with pytest.raises(InputError, match=rf"pack\.npz: lacks {key}"):
            read_mesh_pack(changed(pack, **{key: None}))

    @pytest.mark.parametrize(
        ("key", "dtype", "reason"),
        [
            ("verts_u16", "float32", "not of uint16"),
            ("verts_u16", "uint8", "must be uint16"),
            ("faces", "float64", "not of whole numbers"),
            ("voff", "float64", "not of whole numbers"),
            ("scale", "int64", "not of fractions"),
            ("class10", "float32", "not of signed whole numbers"),
            ("furniture_size", "int8", "not of truth values"),
            ("name", "object", "not of text"),
            ("classes", "|S5", "not of text"),
        ],
    )
    def test_wrong_type_is_named(self, pack, key, dtype, reason):
        with pytest.raises(InputError, match=rf"pack\.npz: {key}.*{reason}"):
            read_mesh_pack(changed(pack, **{key: np.load(pack)[key].astype(dtype)}))

    @pytest.mark.parametrize(
        ("key", "index", "value", "reason"),
        [
            ("faces", (0, 1), 60000, r"mesh 0 \(Chair\): a face names vertex 60000"),
            ("voff", 0, 1, "the offsets of vertices run from 1"),
            ("voff", -1, 2, "the offsets of vertices run from 0 to 2"),
            ("voff", 2, 10**12, "the offsets of vertices do not increase"),
            ("foff", 2, 0, "the offsets of faces do not increase"),
            ("foff", 2, -5, "the offsets of faces do not increase"),
            ("scale", 3, 0.0, r"mesh 3 \(Chair\): scale"),
            ("scale", 3, np.nan, r"mesh 3 \(Chair\): scale"),
            ("offset", (1, 2), np.inf, r"mesh 1 \(Chair\): offset"),
            ("dims", (4, 0), -1.0, r"mesh 4 \(Chair\): sizes"),
            ("class10", 2, 2, r"mesh 2 \(Chair\): the label"),
            ("class10", 2, -3, r"mesh 2 \(Chair\): the label"),
        ],
    )
    def test_value_out_of_range_is_named(self, pack, key, index, value, reason):
        array = np.load(pack)[key].copy()
        array[index] = value
        with pytest.raises(InputError, match=rf"pack\.npz: {reason}"):
            read_mesh_pack(changed(pack, **{key: array}))

    def test_negative_faces(self, pack):
        faces = np.load(pack)["faces"].astype(np.int32)
        faces[3, 1] = -2
        with pytest.raises(InputError, match="a face names vertex -2"):
            read_mesh_pack(changed(pack, faces=faces))

    def test_offsets_beyond_signed_numbers(self, pack):
        starts = np.load(pack)["foff"].astype(np.uint64)
        starts[2] = 2**63 + 1
        with pytest.raises(InputError, match="do not increase"):
            read_mesh_pack(changed(pack, foff=starts))

    @pytest.mark.parametrize(
        ("key", "shape"),
        [("faces", (-1,)), ("verts_u16", (3, -1)), ("offset", (-1,)), ("voff", (-1, 1)),
         ("class10", (1, -1)), ("classes", (1, -1)), ("name", (-1, 1)), ("dims", (3, -1))],
    )  # fmt: skip
    def test_wrong_shape_is_refused(self, pack, key, shape):
        with pytest.raises(InputError, match=r"pack\.npz: .*must have shape"):
            read_mesh_pack(changed(pack, **{key: np.load(pack)[key].reshape(shape)}))

    @pytest.mark.parametrize("key", ["name", "scale", "voff", "furniture_size", "class10"])
    def test_arrays_of_other_lengths(self, pack, key):
        with pytest.raises(InputError, match=r"pack\.npz: .*must have shape"):
            read_mesh_pack(changed(pack, **{key: np.load(pack)[key][:-1]}))

    @pytest.mark.parametrize("classes", [[], ["bed", "bed"]])
    def test_no_classes_or_twice_the_same(self, pack, classes):
        with pytest.raises(InputError, match="classes must hold"):
            read_mesh_pack(changed(pack, classes=np.array(classes, np.str_)))

    def test_no_meshes(self, pack):
        with pytest.raises(InputError, match="must have shape"):
            read_mesh_pack(changed(pack, class10=np.zeros(0, np.int8)))

    @given(seed=st.integers(0, 2**32 - 1))
    def test_mutated_packs_give_a_set_or_a_known_error(self, tmp_path_factory, seed):
        path = tmp_path_factory.getbasetemp() / "mutated_meshes.npz"
        write_mesh_pack(path, [entry(0), entry(1, OTHER)], CLASSES)
        rng = np.random.default_rng(seed)
        content = bytearray(path.read_bytes())
        for place in rng.integers(0, len(content), rng.integers(1, 6)):
            content[place] = rng.integers(256)
        path.write_bytes(content)
        with suppress(InputError):
            meshes = read_mesh_pack(path)
            assert all(len(meshes.mesh(i).faces) for i in range(len(meshes)))

    def test_an_empty_pack_is_not_written(self, tmp_path):
        with pytest.raises(InputError, match="at least one mesh"):
            write_mesh_pack(tmp_path / "p.npz", [], CLASSES)
        assert not list(tmp_path.iterdir())

    def test_labels_without_a_class_are_not_written(self, tmp_path):
        with pytest.raises(InputError, match="the label"):
            write_mesh_pack(tmp_path / "p.npz", [entry(0, 2)], CLASSES)
        assert not list(tmp_path.iterdir())

    def test_a_place_that_can_not_be_written(self, tmp_path):
        (tmp_path / "file").touch()
        with pytest.raises(OutputError, match="can not be written"):
            write_mesh_pack(tmp_path / "file" / "p.npz", [entry(0)], CLASSES)


def test_development_data_is_read(data_folder):
    path = data_folder / "sweethome3d" / "meshes.npz"
    if not path.is_file():
        pytest.skip(f"no {path}")
    meshes = read_mesh_pack(path)
    assert (len(meshes), len(meshes.labelled), len(meshes.others)) == (912, 149, 336)
    assert len(set(meshes.names)) == 912
    for index in range(0, 912, 50):
        vertices = meshes.mesh(index).vertices_xyz
        assert abs(vertices[:, 2].min()) < 5e-3
        assert np.ptp(vertices, axis=0) == pytest.approx(meshes.metres[index], rel=0.02, abs=5e-3)
