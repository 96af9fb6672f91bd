"""LAS, LAZ, E57 and USD, which libraries read: the same points, and one line for broken files."""

from __future__ import annotations

import importlib
import logging
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shape_files

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry import read_cloud, read_mesh

POINTS = shape_files.POINTS


def write_las(path: Path, points: np.ndarray = POINTS) -> Path:
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales, header.offsets = [1 / 64] * 3, [100.0, 0.0, -50.0]
    data = laspy.LasData(header)
    data.x, data.y, data.z = points.T
    data.write(path)
    return path


def write_e57(path: Path, translation: tuple[float, ...] = (0, 0, 0)) -> Path:
    pye57 = pytest.importorskip("pye57")
    with pye57.E57(str(path), mode="w") as file:
        for part in (POINTS[:20], POINTS[20:]):
            axes = zip(("cartesianX", "cartesianY", "cartesianZ"), part.T, strict=True)
            columns = {name: np.ascontiguousarray(column) for name, column in axes}
            file.write_scan_raw(columns, translation=np.array(translation, float))
    return path


def write_usd(path: Path, up: str = "Z", unit_m: float = 1.0, **more: Any) -> Path:
    pytest.importorskip("pxr")
    usd, geom = (importlib.import_module(f"pxr.{name}") for name in ("Usd", "UsdGeom"))
    stage = usd.Stage.CreateNew(str(path))
    geom.SetStageUpAxis(stage, up)
    geom.SetStageMetersPerUnit(stage, unit_m)
    if more.get("cloud"):
        geom.Points.Define(stage, "/cloud").CreatePointsAttr(POINTS.tolist())
    else:
        place = geom.Xform.Define(stage, "/object")
        place.AddTranslateOp().Set((10.0, 20.0, 30.0))
        mesh = geom.Mesh.Define(stage, "/object/box")
        mesh.CreatePointsAttr(shape_files.QUAD_VERTICES.tolist())
        mesh.CreateFaceVertexCountsAttr([4] * 6)
        mesh.CreateFaceVertexIndicesAttr([i for quad in shape_files.QUADS for i in quad])
        hidden = geom.Mesh.Define(stage, "/object/hidden")
        hidden.CreatePointsAttr([(0, 0, 0), (99, 0, 0), (0, 99, 0)])
        hidden.CreateFaceVertexCountsAttr([3])
        hidden.CreateFaceVertexIndicesAttr([0, 1, 2])
        hidden.MakeInvisible()
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_las_coordinates_are_scaled_and_moved(suffix: str, tmp_path: Path):
    cloud = read_cloud(write_las(tmp_path / f"a.{suffix}"))
    np.testing.assert_allclose(cloud.points_xyz, POINTS, atol=1e-9)


def test_e57_scans_share_one_frame(tmp_path: Path):
    cloud = read_cloud(write_e57(tmp_path / "a.e57", (1.0, 2.0, 3.0)))
    np.testing.assert_allclose(cloud.points_xyz, POINTS + [1, 2, 3], atol=1e-6)  # noqa: RUF005


@pytest.mark.parametrize("suffix", ["usda", "usdc", "usdz"])
@pytest.mark.parametrize("up", ["Y", "Z"])
def test_usd_states_its_axis_and_unit(suffix: str, up: str, tmp_path: Path):
    path = write_usd(
        tmp_path / "a.usdc" if suffix == "usdz" else tmp_path / f"a.{suffix}", up, 0.01
    )
    if suffix == "usdz":
        importlib.import_module("pxr.UsdUtils").CreateNewUsdzPackage(
            str(path), str(tmp_path / "a.usdz")
        )
        path = tmp_path / "a.usdz"
    mesh = read_mesh(path)
    vertices = (shape_files.QUAD_VERTICES + np.array([10, 20, 30])) * 0.01
    x, y, z = vertices.T
    expected = vertices if up == "Z" else np.stack([x, -z, y], axis=1)
    np.testing.assert_allclose(mesh.vertices_xyz, expected, atol=1e-9)
    assert mesh.areas.sum() == pytest.approx(shape_files.AREA * 1e-4)
    # What the user says counts.
    np.testing.assert_allclose(read_mesh(path, up="z").vertices_xyz, vertices, atol=1e-9)


def test_usd_points_are_a_cloud(tmp_path: Path):
    cloud = read_cloud(write_usd(tmp_path / "a.usda", cloud=True))
    np.testing.assert_allclose(cloud.points_xyz, POINTS)


@pytest.mark.parametrize("asset", ["/etc/passwd", "../secret.usda", "file:///etc/passwd"])
@pytest.mark.parametrize("arc", ["subLayers = [@{}@]", "references"])
def test_usd_does_not_open_files_outside_of_its_folder(asset: str, arc: str, tmp_path: Path):
    pytest.importorskip("pxr")
    (tmp_path / "scene").mkdir()
    write_usd(tmp_path / "secret.usda")
    path = tmp_path / "scene" / "a.usda"
    text = f'#usda 1.0\ndef "a" (references = @{asset}@</object>) {{}}\n'
    if arc != "references":
        text = f"#usda 1.0\n({arc.format(asset)})\n"
    path.write_text(text)
    with pytest.raises(InputError, match="outside of its folder"):
        read_cloud(path)


def test_usd_refers_to_files_beside_it(tmp_path: Path):
    write_usd(tmp_path / "part.usda")
    path = tmp_path / "a.usda"
    path.write_text(
        '#usda 1.0\n(upAxis = "Z"\nmetersPerUnit = 1)\ndef "a" (references = @./part.usda@</object>) {}\n'
    )
    assert read_mesh(path).areas.sum() == pytest.approx(shape_files.AREA)


WRITERS = {"a.las": write_las, "a.laz": write_las, "a.e57": write_e57, "a.usdc": write_usd}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("share", [0.05, 0.5, 0.9])
def test_truncated_files_are_one_line(name: str, share: float, tmp_path: Path):
    data = WRITERS[name](tmp_path / name).read_bytes()
    (tmp_path / f"cut-{name}").write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError) as error:
        read_cloud(tmp_path / f"cut-{name}")
    assert str(error.value).isprintable()


@pytest.mark.parametrize("name", WRITERS)
def test_content_wins_over_the_suffix(name: str, tmp_path: Path):
    path = WRITERS[name](tmp_path / name).rename(tmp_path / "renamed.xyz")
    if name == "a.usdc":  # Its library goes by the name.
        with pytest.raises(InputError, match=r"is a USD file .* ends in \.usdc"):
            read_cloud(path)
    else:
        assert len(read_cloud(path)) > 0


@pytest.mark.parametrize(
    ("name", "package", "extra"),
    [
        ("a.las", "laspy", "formats"),
        ("a.e57", "pye57", "formats"),
        ("a.usda", "pxr.UsdUtils", "usd"),
    ],
)
def test_a_missing_library_is_named_with_its_extra(
    name: str, package: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / name).write_bytes(b"something")
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=rf"circumspect\[{extra}\]"):
        read_cloud(tmp_path / name)


def test_libraries_are_silent_about_broken_files(tmp_path: Path):
    for name, write in WRITERS.items():
        data = write(tmp_path / name).read_bytes()
        (tmp_path / name).write_bytes(data[: len(data) // 2])
    program = (
        "import sys; from circumspect.geometry import read_cloud\n"
        "from circumspect.errors import InputError\n"
        "for path in sys.argv[1:]:\n"
        "    try: read_cloud(path, samples=3)\n"
        "    except InputError: pass\n"
    )
    done = subprocess.run(
        [sys.executable, "-W", "always", "-c", program, *map(str, tmp_path.iterdir())],
        capture_output=True,
        text=True,
        check=True,
    )
    assert (done.stdout, done.stderr) == ("", "")


def test_invalid_e57_points_are_dropped(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    pye57 = pytest.importorskip("pye57")
    states = np.zeros(len(POINTS), np.int8)
    states[::5] = 2
    with pye57.E57(str(tmp_path / "a.e57"), mode="w") as file:
        axes = zip(("cartesianX", "cartesianY", "cartesianZ"), POINTS.T, strict=True)
        columns = {name: np.ascontiguousarray(column) for name, column in axes}
        file.write_scan_raw({**columns, "cartesianInvalidState": states})
    with caplog.at_level(logging.WARNING):
        assert len(read_cloud(tmp_path / "a.e57")) == (states == 0).sum()
