"""The unit of an object's coordinates, from the command line to the classifier."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from circumspect.classification import Classifier, OnnxClassifier
from circumspect.cli.main import main
from circumspect.cli.object_cloud import METRES, grid_in_metres, metres_per_unit
from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, RectangularGrid
from circumspect.grid.cell_centres import occupied_centres

CHAIR = make_furniture("chair", 3).sampled(5_000, 0)
Asked = list[tuple[float, bool]]


def longest(points_xyz: np.ndarray) -> float:
    return float(np.ptp(points_xyz, axis=0).max())


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Asked:
    """The longest side [m] and `metric` of each object given to the classifier."""
    found: Asked = []
    classify, classify_grid = OnnxClassifier.classify, OnnxClassifier.classify_grid

    def cloud(self: OnnxClassifier, cloud: PointCloud, *, metric: bool = False) -> object:
        found.append((longest(cloud.points_xyz), metric))
        return classify(self, cloud, metric=metric)

    def grid(self: OnnxClassifier, *views, metric: bool = False) -> object:
        found.append((longest(occupied_centres(views[0])), metric))
        return classify_grid(self, *views, metric=metric)

    monkeypatch.setattr(OnnxClassifier, "classify", cloud)
    monkeypatch.setattr(OnnxClassifier, "classify_grid", grid)
    return found


def saved(folder: Path, scale: float, name: str = "chair.npy") -> str:
    np.save(folder / name, CHAIR.points_xyz * scale)
    return str(folder / name)


def saved_grid(folder: Path, scale: float) -> str:
    cloud = PointCloud(CHAIR.points_xyz * scale)
    Classifier.load(threads=1).input_spec.bounds(cloud).hits(cloud).save(folder / "grid.npz")
    return str(folder / "grid.npz")


@pytest.mark.parametrize("make", [saved, saved_grid])
@pytest.mark.parametrize("unit", METRES)
def test_a_cloud_and_a_grid_reach_the_classifier_in_metres(
    unit: str, make: Callable[[Path, float], str], tmp_path: Path, asked: Asked
) -> None:
    file = make(tmp_path, 1.0 / METRES[unit])
    assert main(["classify", file, "--unit", unit]) == 0
    ((size, metric),) = asked
    assert size == pytest.approx(longest(CHAIR.points_xyz), rel=0.1)
    assert metric


@pytest.mark.parametrize("words", [[], ["--unit", "unknown"]])
def test_the_scale_of_most_files_is_unknown(words: list[str], tmp_path: Path, asked: Asked) -> None:
    assert main(["classify", saved(tmp_path, 1000.0), *words]) == 0
    ((size, metric),) = asked
    assert size == pytest.approx(1000.0 * longest(CHAIR.points_xyz))
    assert not metric


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".GLB"])
def test_gltf_is_in_metres_unless_another_unit_is_given(suffix: str) -> None:
    file = Path("chair" + suffix)
    assert metres_per_unit(file, None) == 1.0
    assert metres_per_unit(file, "cm") == 0.01
    assert metres_per_unit(file, "unknown") is None
    assert metres_per_unit(Path("chair.stl"), None) is None


def test_a_glb_file_is_classified_by_its_size(tmp_path: Path, asked: Asked) -> None:
    import trimesh

    chair = make_furniture("chair", 3)
    mesh = trimesh.Trimesh(chair.vertices_xyz, chair.faces)
    (tmp_path / "chair.glb").write_bytes(mesh.export(file_type="glb"))
    assert main(["classify", str(tmp_path / "chair.glb")]) == 0
    assert asked[0][1]


@pytest.mark.parametrize("command", ["classify", "explain"])
@pytest.mark.parametrize("make", [saved, saved_grid])
@pytest.mark.parametrize(("size", "unit", "shown"), [(0.5, "mm", "0.5 mm"), (80.0, "m", "80 m")])
def test_an_impossible_size_is_one_line_and_exit_code_2(
    size: float, unit: str, shown: str, make: Callable[[Path, float], str], command: str,
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    file = make(tmp_path, size / longest(CHAIR.points_xyz))
    assert main([command, file, "--unit", unit]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert file in err
    assert (shown in err) or make is saved_grid
    assert "check the unit of its points: m, cm, mm or in" in err


def test_explain_asks_in_the_same_unit(
    tmp_path: Path, asked: Asked, capsys: pytest.CaptureFixture[str], monkeypatch
) -> None:
    from circumspect.classification import evidence

    monkeypatch.setattr(evidence.cell_evidence, "__defaults__", (None, (1.0,), None))
    file = saved(tmp_path, 100.0)
    words = ["explain", file, "--unit", "cm", "--json", "--near", "1", "--out", str(tmp_path)]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["label"] == "chair"
    assert all(metric for _, metric in asked)
    sizes = [size for size, _ in asked]
    assert sizes == pytest.approx([longest(CHAIR.points_xyz)] * len(sizes), rel=0.1)


def test_an_unknown_unit_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["classify", saved(tmp_path, 1.0), "--unit", "yard"])
    assert ended.value.code == 2
    assert "yard" in capsys.readouterr().err


@pytest.mark.parametrize("kind", [CylindricalGrid, RectangularGrid])
def test_scaling_a_grid_scales_its_content(kind: type) -> None:
    cloud = PointCloud(CHAIR.points_xyz + np.array([3.0, -2.0, 1.0]))
    grid = kind.fit(cloud, (16, 16, 16)).hits(cloud)
    scaled = grid_in_metres(grid, 0.5)
    np.testing.assert_array_equal(scaled.states, grid.states)
    np.testing.assert_allclose(occupied_centres(scaled), 0.5 * occupied_centres(grid))
    assert grid_in_metres(grid, None) is grid


def test_a_scaled_grid_holds_the_scaled_cloud() -> None:
    grid = CylindricalGrid.fit(CHAIR, (16, 16, 16))
    smaller = grid.scaled(0.0254).hits(PointCloud(0.0254 * CHAIR.points_xyz))
    assert (smaller.states != grid.hits(CHAIR).states).mean() < 1e-3
    with pytest.raises(InputError):
        grid.scaled(0.0)
