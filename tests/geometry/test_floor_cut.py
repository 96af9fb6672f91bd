"""The floor is removed, the object is kept, whatever the scan is like."""

from __future__ import annotations

import numpy as np
import pytest
from scanned_floor import on_floor
from scipy.spatial.transform import Rotation

from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PointCloud, cut_floor
from circumspect.geometry.clusters import connected_clusters
from circumspect.geometry.supporting_plane import find_supporting_plane, largest_with_all_above

SCANS = {
    "clean": {},
    "noisy": {"noise": 0.004},
    "narrow floor": {"beyond": 1.35, "share": 0.3},
    "wide floor": {"beyond": 3.0, "share": 0.85, "noise": 0.004},
    "with a wall": {"wall": True, "noise": 0.004},
    "with strays": {"strays": 60, "noise": 0.004},
    "leaning": {"lean": 0.2, "noise": 0.003},
}


@pytest.mark.parametrize("kind", SCANS)
@pytest.mark.parametrize("category", ["chair", "table", "night_stand", "toilet"])
def test_the_floor_is_removed_and_the_object_kept(kind: str, category: str):
    points, is_object = on_floor(category, **SCANS[kind])
    cut = cut_floor(PointCloud(points))
    assert cut is not None
    assert cut.kept[is_object].mean() > 0.85
    assert cut.kept[~is_object].mean() < 0.08
    assert cut.floor_points + cut.other_points + len(cut.cloud) == len(points)
    np.testing.assert_array_equal(cut.cloud.points_xyz, points[cut.kept])
    assert cut.tilt == pytest.approx(SCANS[kind].get("lean", 0.0), abs=0.02)
    if kind == "with a wall":
        assert cut.other_points > 3000


def test_the_remaining_object_is_level():
    points, _ = on_floor("chair", lean=0.3)
    cut = cut_floor(PointCloud(points))
    assert cut is not None
    upright = make_furniture("chair", 3).sampled(12_000, 0).points_xyz
    height = np.ptp(cut.levelled().points_xyz[:, 2])
    assert height == pytest.approx(np.ptp(upright[:, 2]), rel=0.06)


def test_areas_and_normals_are_kept_with_their_points():
    points, _ = on_floor("chair")
    normals = np.random.default_rng(0).normal(size=points.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    areas = np.arange(len(points), dtype=float)
    cut = cut_floor(PointCloud(points, areas=areas, normals_xyz=normals))
    assert cut is not None
    np.testing.assert_array_equal(cut.cloud.areas, areas[cut.kept])
    np.testing.assert_array_equal(cut.cloud.normals_xyz, normals[cut.kept])


@pytest.mark.parametrize("category", CATEGORIES)
def test_an_object_without_a_floor_is_unchanged(category: str):
    cloud = make_furniture(category, 3).sampled(12_000, 0)
    assert cut_floor(cloud) is None


def test_hardly_any_real_object_is_cut(data_folder):
    from circumspect.datasets import open_data_set

    objects = open_data_set(data_folder / "modelnet10", "train")
    some = range(0, len(objects), 40)
    clouds = (PointCloud(objects.points_xyz[index].astype(np.float64)) for index in some)
    assert sum(cut_floor(cloud) is not None for cloud in clouds) <= 2


@pytest.mark.parametrize("seed", range(3))
def test_a_floor_of_any_direction_is_found_on_request(seed: int):
    points, is_object = on_floor("chair", noise=0.003)
    turn = Rotation.random(rng=np.random.default_rng(seed))
    cut = cut_floor(PointCloud(turn.apply(points)), any_way_up=True)
    assert cut is not None
    assert cut.plane.normal_xyz @ turn.apply([0, 0, 1]) > 0.99
    assert cut.kept[is_object].mean() > 0.85
    assert cut.kept[~is_object].mean() < 0.05


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_scale_and_place_do_not_matter(scale: float, offset: float):
    points, _ = on_floor("chair", noise=0.003)
    plain = cut_floor(PointCloud(points))
    moved = cut_floor(PointCloud((points + offset) * scale))
    assert plain is not None
    assert moved is not None
    assert (plain.kept == moved.kept).mean() > 0.98


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((500, 3)),
        np.random.default_rng(0).random((5, 3)),
        np.random.default_rng(0).random((5000, 3)) * [1, 1, 0],
        np.random.default_rng(0).normal(size=(5000, 3)),
        np.column_stack([np.linspace(0, 1, 500)] * 3),
    ],
)
def test_clouds_without_floor_and_object_are_left_alone(points: np.ndarray):
    assert cut_floor(PointCloud(points)) is None
    assert cut_floor(PointCloud(points), any_way_up=True) is None


def test_the_plane_is_that_of_the_floor():
    points, is_object = on_floor("table", noise=0.002)
    plane = find_supporting_plane(points, np.array([0.0, 0.0, 1.0]))
    assert plane is not None
    heights = plane.heights(points[~is_object])
    assert np.abs(heights.mean()) < 0.003
    assert (np.abs(heights) < plane.tolerance).mean() > 0.9


def test_clusters_are_joined_by_chains_of_short_steps():
    rng = np.random.default_rng(0)
    line = np.linspace([0, 0, 0], [9, 0, 0], 100)
    far = rng.random((50, 3)) + np.array([0, 5, 0])
    order = rng.permutation(150)
    clusters = connected_clusters(np.concatenate([line, far])[order], 0.5)
    of_line = order < 100
    assert len(set(clusters[of_line])) == len(set(clusters[~of_line])) == 1
    assert set(clusters[of_line]) != set(clusters[~of_line])


def test_the_largest_hypothesis_with_nothing_below_is_taken():
    rng = np.random.default_rng(0)
    heights = np.repeat([0.0, 1.0, 2.0], [300, 500, 200])
    points = np.column_stack([rng.uniform(-1, 1, (1000, 2)), heights])
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    # The largest plane has points below; of the two others that lie at 0 the first is taken.
    offsets = np.array([2.0, 1.0, 0.0, 0.0])
    assert largest_with_all_above(points, normals, offsets, 0.1, 0.1, 10) == 2
    assert largest_with_all_above(points, -normals, -offsets, 0.1, 0.1, 10) == 0
    assert largest_with_all_above(points, normals, offsets, 0.1, 0.1, 300) is None
    assert largest_with_all_above(points, normals, offsets, np.full(1000, 0.1), 0.1, 299) == 2
