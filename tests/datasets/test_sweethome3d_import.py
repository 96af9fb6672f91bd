"""Catalogues of Sweet Home 3D: meshes as the program places them, and untrusted files."""

import struct
import zipfile
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from sh3f_files import CHAIR, PROPERTIES, piece, write_sh3f, zipped

from circumspect.datasets import sweethome3d_catalogue, sweethome3d_import
from circumspect.datasets.mesh_pack import OTHER, read_mesh_pack, write_mesh_pack
from circumspect.datasets.sweethome3d_catalogue import PieceError, SkipCode
from circumspect.datasets.sweethome3d_classes import CLASSES
from circumspect.datasets.sweethome3d_import import import_sweethome3d, placed_model
from circumspect.errors import InputError


def one(tmp_path, *properties, **options):
    """The result for a catalogue of these properties."""
    return import_sweethome3d(write_sh3f(tmp_path / "test.sh3f", "".join(properties), **options))


def skipped_code(tmp_path, properties, **options):
    """Why a second piece beside a valid one is skipped."""
    options.setdefault("models", {"folder/chair.obj": CHAIR})
    imported = one(tmp_path, piece(1), properties, **options)
    assert len(imported.entries) == 1
    (skipped,) = imported.skipped
    assert skipped.number == 2
    assert "\n" not in skipped.reason
    return skipped.code


class TestPlacement:
    def test_chair_faces_the_front_and_stands_on_the_floor_in_metres(self, tmp_path):
        (entry,) = one(tmp_path, piece()).entries
        vertices = entry.packed.mesh().vertices_xyz
        np.testing.assert_allclose(vertices.min(axis=0), [-0.25, -0.3, 0], atol=1e-4)
        np.testing.assert_allclose(vertices.max(axis=0), [0.25, 0.3, 0.9], atol=1e-4)
        top = vertices[vertices[:, 2] > 0.8]
        np.testing.assert_allclose(top[:, 1], 0.3, atol=1e-4)

    def test_record_is_carried_along(self, tmp_path):
        (entry,) = one(tmp_path, piece(category="B\\u00fcro", creator="J\xf6rg")).entries
        assert entry.title == "Chair"
        assert entry.category == "Büro"
        assert entry.creator == "Jörg"
        assert entry.licence == "CC-BY 3.0 © Somebody"
        assert entry.catalogue == "test"
        assert entry.model_id == "folder/chair.obj"
        assert entry.metres == (0.5, 0.6, 0.9)
        assert CLASSES[entry.label] == "chair"
        assert entry.furniture_size

    def test_licence_of_a_piece_takes_precedence_over_that_of_the_catalogue(self, tmp_path):
        imported = one(tmp_path, piece(license="CC0"), piece(2, width="70"))
        assert [entry.licence for entry in imported.entries] == ["CC0", "CC-BY 3.0 © Somebody"]

    def test_model_rotation_turns_before_scaling(self, tmp_path):
        quarter = "0 0 1 0 1 0 -1 0 0"  # The back, at -z, comes to -x.
        (entry,) = one(tmp_path, piece(modelRotation=quarter)).entries
        vertices = entry.packed.mesh().vertices_xyz
        np.testing.assert_allclose(np.ptp(vertices, axis=0), [0.5, 0.6, 0.9], atol=1e-4)
        top = vertices[vertices[:, 2] > 0.8]
        np.testing.assert_allclose(top[:, 0], -0.25, atol=1e-4)

    @given(
        turn=st.tuples(*[st.floats(-180, 180)] * 3),
        metres=st.tuples(*[st.floats(0.01, 20)] * 3),
        shift=st.floats(-1e3, 1e3),
    )
    def test_box_is_that_of_the_properties(self, turn, metres, shift):
        rng = np.random.default_rng(0)
        rows = [f"v {x} {y} {z}" for x, y, z in rng.normal(size=(20, 3)) + shift]
        rows += [
            f"f {a} {b} {c}"
            for a, b, c in rng.permuted(np.tile(np.arange(1, 21), (30, 1)), axis=1)[:, :3]
        ]
        rotation = Rotation.from_euler("xyz", turn, degrees=True).as_matrix()
        vertices = placed_model("\n".join(rows).encode(), metres, rotation).mesh().vertices_xyz
        step = max(metres) / 65535
        np.testing.assert_allclose(np.ptp(vertices, axis=0), metres, atol=step)
        np.testing.assert_allclose(
            vertices.min(axis=0), [-metres[0] / 2, -metres[1] / 2, 0], atol=step
        )

    def test_flat_models_stay_flat(self, tmp_path):
        obj = "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"
        (entry,) = one(tmp_path, piece(), models={"folder/chair.obj": obj}).entries
        np.testing.assert_allclose(
            np.ptp(entry.packed.mesh().vertices_xyz, axis=0), [0.5, 0.6, 0], atol=1e-4
        )


class TestCatalogues:
    def test_numbers_may_have_gaps_and_any_order(self, tmp_path):
        imported = one(tmp_path, piece(12, name="Bed", depth="200"), piece(3), "dropOnTopElevation#-1=2\nx#y=1\n",
                       piece(9, width="20"))  # fmt: skip
        assert [entry.title for entry in imported.entries] == ["Chair", "Chair", "Bed"]

    @pytest.mark.parametrize(
        ("model", "members"),
        [
            ("folder/chair.obj", {"folder/chair.obj": CHAIR}),
            ("/folder/CHAIR.OBJ", {"folder/CHAIR.OBJ": CHAIR}),
            ("/a%20chair.obj", {"a chair.obj": CHAIR}),
            ("/a%20chair.obj", {"a%20chair.obj": CHAIR}),
            ("/chair.zip", {"chair.zip": zipped(chair__obj=CHAIR, chair__mtl="")}),
            ("/chair.zip", {"chair.zip": zipped(other__obj="v", chair__obj=CHAIR)}),
            ("/chair.zip", {"chair.zip": zipped(seat__obj=CHAIR)}),
            ("/c.zip!/seat.obj", {"c.zip": zipped(c__obj="v", seat__obj=CHAIR)}),
        ],
    )
    def test_ways_to_name_a_model(self, tmp_path, model, members):
        imported = one(tmp_path, piece(model=model), models=members)
        assert len(imported.entries[0].packed.faces) == 4

    def test_jar_of_the_program_is_a_catalogue(self, tmp_path):
        write_sh3f(
            tmp_path / "sweethome3d.jar",
            piece(name="Bed"),
            name=sweethome3d_catalogue.PROPERTIES[1],
        )
        zipfile.ZipFile(tmp_path / "other.jar", "w").close()
        write_sh3f(tmp_path / "B.SH3F", piece(width="30"))
        imported = import_sweethome3d(tmp_path)
        assert [entry.catalogue for entry in imported.entries] == ["B", "sweethome3d"]

    def test_folders_are_searched(self, tmp_path):
        (tmp_path / "a" / "b").mkdir(parents=True)
        (tmp_path / "folder.sh3f").mkdir()
        write_sh3f(tmp_path / "a" / "b" / "deep.sh3f")
        write_sh3f(tmp_path / "z.sh3f", piece(width="40"))
        assert [e.catalogue for e in import_sweethome3d(tmp_path).entries] == ["deep", "z"]

    def test_progress_counts_all_pieces(self, tmp_path):
        write_sh3f(tmp_path / "a.sh3f", piece() + piece(2, model=None))
        write_sh3f(tmp_path / "b.sh3f", piece(width="40"))
        steps = []
        import_sweethome3d(tmp_path, lambda done, total: steps.append((done, total)))
        assert steps == [(1, 3), (2, 3), (3, 3)]

    def test_pack_of_an_import_is_read(self, tmp_path):
        imported = one(
            tmp_path, piece(), piece(2, name="Wardrobe", category="Bedroom", height="200")
        )
        write_mesh_pack(tmp_path / "p.npz", imported.entries, CLASSES)
        meshes = read_mesh_pack(tmp_path / "p.npz")
        assert [(o.name, o.label) for o in (*meshes.labelled, *meshes.others)] == [
            ("test/folder/chair.obj", "chair"), ("test/folder/chair.obj#2", "other"),
        ]  # fmt: skip
        assert meshes.labels.tolist() == [CLASSES.index("chair"), OTHER]


class TestSkippedPieces:
    @pytest.mark.parametrize(
        ("changes", "code"),
        [
            ({"name": None}, SkipCode.NO_NAME),
            ({"name": ""}, SkipCode.NO_NAME),
            ({"model": None}, SkipCode.NO_MODEL),
            ({"model": " "}, SkipCode.NO_MODEL),
            ({"model": "/nowhere.obj"}, SkipCode.MISSING_FILE),
            ({"model": "../../etc/chair.obj"}, SkipCode.MISSING_FILE),
            ({"model": "http://example.org/chair.obj"}, SkipCode.MISSING_FILE),
            ({"model": "/nowhere.zip"}, SkipCode.MISSING_FILE),
            ({"model": "/nowhere.dae"}, SkipCode.UNREAD_FORMAT),
            ({"model": "/nowhere.3DS"}, SkipCode.UNREAD_FORMAT),
            ({"model": "/nowhere"}, SkipCode.UNREAD_FORMAT),
            ({"width": None}, SkipCode.BAD_SIZE),
            ({"depth": "wide"}, SkipCode.BAD_SIZE),
            ({"height": "0"}, SkipCode.BAD_SIZE),
            ({"height": "-3"}, SkipCode.BAD_SIZE),
            ({"height": "NaN"}, SkipCode.BAD_SIZE),
            ({"height": "inf"}, SkipCode.BAD_SIZE),
            ({"height": "1e9"}, SkipCode.BAD_SIZE),
            ({"modelRotation": "1 0 0"}, SkipCode.BAD_ROTATION),
            ({"modelRotation": "1 0 0 0 1 0 0 0 x"}, SkipCode.BAD_ROTATION),
            ({"modelRotation": "1 0 0 0 1 0 0 0 nan"}, SkipCode.BAD_ROTATION),
            ({"modelRotation": "1 0 0 0 1 0 0 0 -1"}, SkipCode.BAD_ROTATION),
            ({"modelRotation": "2 0 0 0 2 0 0 0 2"}, SkipCode.BAD_ROTATION),
            ({}, SkipCode.DUPLICATE),
        ],
    )
    def test_properties_that_can_not_be_used(self, tmp_path, changes, code):
        assert skipped_code(tmp_path, piece(2, **changes)) == code

    @pytest.mark.parametrize(
        "obj",
        [
            "", "no obj", "v 0 0 0", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3", "v 0 0 0\nf 1 1 1",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3",
            "v 0 0 inf\nv 1 0 0\nv 0 1 0\nf 1 2 3", "v 0 0 1e308\nv 1 0 0\nv 0 1 -1e308\nf 1 2 3",
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3", "v 0 0\nv 1 0\nv 0 1\nf 1 2 3",
            "\0" * 100, b"\xff\xfe\x00v",
        ],
    )  # fmt: skip
    def test_broken_models(self, tmp_path, obj):
        models = {"folder/chair.obj": CHAIR, "bad.obj": obj}
        assert (
            skipped_code(tmp_path, piece(2, model="/bad.obj"), models=models)
            == SkipCode.BROKEN_MODEL
        )

    @pytest.mark.parametrize(
        ("model", "content", "code"),
        [
            ("/bad.zip", "no zip", SkipCode.BROKEN_MODEL),
            ("/bad.zip", zipped(a__dae="x"), SkipCode.UNREAD_FORMAT),
            ("/bad.zip!/a.dae", zipped(a__dae="x"), SkipCode.UNREAD_FORMAT),
            ("/bad.zip!/b.obj", zipped(a__obj=CHAIR), SkipCode.MISSING_FILE),
            ("/bad.zip!/b.zip", zipped(b__zip=zipped(a__obj=CHAIR)), SkipCode.UNREAD_FORMAT),
        ],
    )
    def test_zips_within_the_zip(self, tmp_path, model, content, code):
        models = {"folder/chair.obj": CHAIR, "bad.zip": content}
        assert skipped_code(tmp_path, piece(2, model=model), models=models) == code

    @pytest.mark.parametrize("nested", [False, True])
    def test_bombs_are_not_unpacked(self, tmp_path, nested):
        bomb = b"v 0 0 0\n" * (1 << 20)
        content = bomb
        if nested:
            with zipfile.ZipFile(tmp_path / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr("bomb.obj", bomb)
            content = (tmp_path / "bomb.zip").read_bytes()
        name = "bomb.zip" if nested else "bomb.obj"
        models = {"folder/chair.obj": CHAIR, name: content}
        assert skipped_code(tmp_path, piece(2, model=name), models=models) == SkipCode.TOO_LARGE

    def test_large_models_are_refused_however_they_are_packed(self, tmp_path, monkeypatch):
        monkeypatch.setattr(sweethome3d_catalogue, "MAX_MODEL_BYTES", 1000)
        models = {"folder/chair.obj": CHAIR, "big.obj": CHAIR + "# " + "x" * 1000}
        assert (
            skipped_code(tmp_path, piece(2, model="big.obj"), models=models) == SkipCode.TOO_LARGE
        )

    @pytest.mark.parametrize("damage", ["encrypted", "packing"])
    def test_members_that_can_not_be_unpacked(self, tmp_path, damage):
        path = write_sh3f(
            tmp_path / "test.sh3f", piece(1) + piece(2, model="/bad.obj"),
            models={"folder/chair.obj": CHAIR, "bad.obj": CHAIR + "# bad"},
        )  # fmt: skip
        content = bytearray(path.read_bytes())
        entry = content.rindex(b"PK\x01\x02")  # Of bad.obj, the last in the directory.
        if damage == "encrypted":
            content[entry + 8] |= 1
        else:
            content[entry + 10 : entry + 12] = struct.pack("<H", 14)
        path.write_bytes(content)
        imported = import_sweethome3d(path)
        assert len(imported.entries) == 1
        assert [skipped.code for skipped in imported.skipped] == [SkipCode.BROKEN_MODEL]

    def test_a_broken_model_in_an_intact_zip_is_skipped(self, tmp_path):
        inner = bytearray(zipped(a__obj=CHAIR))
        inner[inner.rindex(b"PK\x01\x02") + 16] ^= 1
        models = {"folder/chair.obj": CHAIR, "bad.zip": bytes(inner)}
        assert (
            skipped_code(tmp_path, piece(2, model="/bad.zip"), models=models)
            == SkipCode.BROKEN_MODEL
        )

    def test_texts_are_cut_and_free_of_control_characters(self, tmp_path):
        imported = one(tmp_path, piece(name="Chair\\u001b[2J" + "x" * 5000))
        assert imported.entries[0].title.startswith("Chair\\x1b[2J")
        assert len(imported.entries[0].title) < 600


class TestRefusals:
    def test_nothing_there(self, tmp_path):
        with pytest.raises(InputError, match=r"nowhere\.sh3f: does not exist"):
            import_sweethome3d(tmp_path / "nowhere.sh3f")
        with pytest.raises(InputError, match=r"no \.sh3f file in it or below it"):
            import_sweethome3d(tmp_path)

    @pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x03\x04" + b"\0" * 50])
    @pytest.mark.parametrize("name", ["bad.sh3f", "bad.jar"])
    def test_a_broken_catalogue_ends_the_import(self, tmp_path, content, name):
        write_sh3f(tmp_path / "good.sh3f")
        (tmp_path / name).write_bytes(content)
        for path in (tmp_path, tmp_path / name):
            with pytest.raises(InputError, match=r"bad\.\w+: is no readable zip") as error:
                import_sweethome3d(path)
            assert "\n" not in str(error.value)

    def test_truncated_catalogue(self, tmp_path):
        path = write_sh3f(tmp_path / "cut.sh3f")
        path.write_bytes(path.read_bytes()[:-40])
        with pytest.raises(InputError, match=r"cut\.sh3f: is no readable zip"):
            import_sweethome3d(path)

    def test_zip_without_properties(self, tmp_path):
        path = write_sh3f(tmp_path / "a.sh3f", name="other.properties")
        with pytest.raises(InputError, match=r"a\.sh3f: holds no PluginFurnitureCatalog"):
            import_sweethome3d(path)

    def test_broken_properties(self, tmp_path):
        with pytest.raises(InputError, match=r"test\.sh3f: has a broken escape"):
            one(tmp_path, piece(name="\\u12"))

    def test_large_properties(self, tmp_path, monkeypatch):
        monkeypatch.setattr(sweethome3d_catalogue, "MAX_PROPERTIES_BYTES", 100)
        with pytest.raises(InputError, match=rf"test\.sh3f: {PROPERTIES} would unpack"):
            one(tmp_path, piece())

    def test_properties_with_a_wrong_checksum(self, tmp_path):
        path = write_sh3f(tmp_path / "a.sh3f")
        content = bytearray(path.read_bytes())
        content[content.index(b"PK\x01\x02") + 16] ^= 1
        path.write_bytes(content)
        with pytest.raises(InputError, match=rf"a\.sh3f: {PROPERTIES} is broken"):
            import_sweethome3d(path)

    def test_a_damaged_model_ends_the_import(self, tmp_path):
        path = write_sh3f(
            tmp_path / "a.sh3f",
            piece(1) + piece(2, model="/bad.obj"),
            models={"folder/chair.obj": CHAIR, "bad.obj": CHAIR + "# bad"},
        )
        content = bytearray(path.read_bytes())
        content[content.rindex(b"PK\x01\x02") + 16] ^= 1  # The checksum of bad.obj.
        path.write_bytes(content)
        with pytest.raises(InputError, match=r"a\.sh3f: is damaged \(Bad CRC") as error:
            import_sweethome3d(path)
        assert "\n" not in str(error.value)

    def test_no_usable_model(self, tmp_path):
        with pytest.raises(
            InputError, match=r"none of its 1 models can be used; number 7 has no width"
        ):
            one(tmp_path, piece(7, width=None))
        with pytest.raises(InputError, match="list no furniture"):
            one(tmp_path, "")

    def test_more_than_a_pack_can_hold(self, tmp_path, monkeypatch):
        monkeypatch.setattr(sweethome3d_import, "MAX_PACK_BYTES", 100)
        with pytest.raises(InputError, match="import fewer catalogues"):
            one(tmp_path, piece(1), piece(2, width="60"))

    @given(seed=st.integers(0, 2**32 - 1))
    def test_mutated_catalogues_give_models_or_a_known_error(self, tmp_path_factory, seed):
        models = {"folder/chair.obj": CHAIR, "c.zip": zipped(chair__obj=CHAIR + "# c")}
        path = write_sh3f(
            tmp_path_factory.getbasetemp() / "mutated.sh3f", piece() + piece(2, model="/c.zip"),
            models=models,
        )  # fmt: skip
        rng = np.random.default_rng(seed)
        content = bytearray(path.read_bytes())
        for place in rng.integers(0, len(content), rng.integers(1, 6)):
            content[place] = rng.integers(256)
        path.write_bytes(content)
        with suppress(InputError):
            assert import_sweethome3d(path).entries

    @given(
        lines=st.lists(
            st.one_of(
                st.builds("v {} {} {}".format, *[st.floats()] * 3),
                st.builds("f {} {} {}".format, *[st.integers(-9, 9)] * 3),
                st.text(max_size=10),
            )
        )
    )
    def test_any_model_is_read_or_skipped(self, lines):
        data = "\n".join(lines).encode("utf-8", "surrogatepass")
        with suppress(PieceError):
            packed = placed_model(data, (1.0, 1.0, 1.0), np.eye(3))
            assert len(packed.mesh().faces)
