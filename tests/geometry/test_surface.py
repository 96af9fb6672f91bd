"""Sparse points joined into a surface."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import shape_files
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import KDTree

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import (
    PointCloud,
    TriangleMesh,
    _native,
    fill_surface,
    short_edge_triangles,
)


def spread_points(mesh: TriangleMesh, count: int, seed: int = 0) -> np.ndarray:
    """Nearly a Poisson-disk sample: of many points those farthest from all chosen before."""
    many = mesh.sampled(20 * count, seed).points_xyz
    chosen = [0]
    distance = np.linalg.norm(many - many[0], axis=1)
    while len(chosen) < count:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(many - many[chosen[-1]], axis=1))
    return many[chosen]


BOX = TriangleMesh(shape_files.VERTICES, shape_files.FACES)
BOX_POINTS = spread_points(BOX, 500)


def triangles_by_definition(
    points: np.ndarray, neighbours: int, reach: float
) -> set[tuple[int, ...]]:
    distances = np.linalg.norm(points[:, None] - points[None], axis=-1)
    nearest = np.argsort(distances, axis=1, kind="stable")[:, 1:]
    medians = np.median(np.sort(distances, axis=1)[:, 1:7], axis=0)
    behind_jumps = [i for i in range(1, len(medians)) if medians[i] > 1.45 * medians[i - 1]]
    longest = reach * medians[max(behind_jumps, default=0)]
    found = set()
    for apex, row in enumerate(nearest):
        for pair in combinations(row[:neighbours].tolist(), 2):
            triangle = tuple(sorted((apex, *pair)))
            if all(distances[i, j] <= longest for i, j in combinations(triangle, 2)):
                found.add(triangle)
    return found


@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(3, 40),
    neighbours=st.integers(2, 12),
    reach=st.floats(0.8, 3),
    sheets=st.integers(1, 3),
)
def test_triangles_equal_those_of_the_definition(
    seed: int, count: int, neighbours: int, reach: float, sheets: int
):
    points = np.random.default_rng(seed).normal(size=(count, 3)) * [1, 1, 0.1]
    points = np.concatenate([points + np.array([0, 0, 0.003 * sheet]) for sheet in range(sheets)])
    expected = triangles_by_definition(points, neighbours, reach)
    if not expected:
        with pytest.raises(GeometryError, match="no three points"):
            short_edge_triangles(points, neighbours, reach)
        return
    faces = short_edge_triangles(points, neighbours, reach).faces
    assert [tuple(face) for face in faces.tolist()] == sorted(expected)


def test_triangles_of_many_points_equal_those_of_a_tree():
    points = BOX.sampled(20_000, 3).points_xyz
    scaled = (points - points[0]) / float(np.ptp(points, axis=0).max())
    longest = 3.0 * _native.spacing(np.ascontiguousarray(scaled))
    away, near = KDTree(scaled).query(scaled[:50], 9, distance_upper_bound=longest)
    expected = set()
    for apex, (distances, row) in enumerate(zip(away[:, 1:], near[:, 1:], strict=True)):
        for one, other in combinations(row[np.isfinite(distances)].tolist(), 2):
            if np.linalg.norm(scaled[one] - scaled[other]) <= longest:
                expected.add(tuple(sorted((apex, one, other))))
    faces = set(map(tuple, short_edge_triangles(points, 8, 3.0).faces.tolist()))
    assert len(expected) > 500
    assert expected <= faces


@pytest.mark.parametrize("sheets", [1, 2, 4])
def test_spacing_is_measured_within_a_sheet(sheets: int):
    grid = np.stack(np.meshgrid(np.arange(16), np.arange(16), [0.0]), axis=-1).reshape(-1, 3) / 16
    points = np.concatenate([grid + np.array([0, 0, 0.002 * sheet**2]) for sheet in range(sheets)])
    assert _native.spacing(points) == pytest.approx(1 / 16, rel=0.1)


def test_the_surface_of_a_box_is_closed():
    mesh = short_edge_triangles(BOX_POINTS)
    probe = BOX.sampled(3000, 5).points_xyz
    bare, _ = KDTree(BOX_POINTS).query(probe)
    filled, _ = KDTree(mesh.sampled(30_000, 6).points_xyz).query(probe)
    # Points are some 0.2 m apart; what is left is the rim along the edges of the box.
    assert np.quantile(bare, 0.9) > 0.1
    assert np.quantile(filled, 0.9) < 0.04


def test_both_sides_of_a_thin_wall_are_closed():
    """The nearest neighbour is across the wall; the spacing must come from the side itself."""
    corners = np.array([[0.0, 0, 0], [2, 0, 0], [2, 0, 2], [0, 0, 2]])
    wall = TriangleMesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    side = spread_points(wall, 300)
    both = np.vstack([side, side + np.array([0.001, 0.01, 0.0005])])
    samples = short_edge_triangles(both).sampled(60_000).points_xyz
    probe = wall.sampled(2000, 9).points_xyz
    inner = (np.abs(probe[:, [0, 2]] - 1) < 0.85).all(axis=1)
    bare, _ = KDTree(both).query(probe[inner])
    filled, _ = KDTree(samples).query(probe[inner])
    assert bare.max() > 0.07
    assert filled.max() < 0.055


@given(seed=st.integers(0, 2**32 - 1), exponent=st.sampled_from([-150, -12, 6, 12, 90]))
def test_scale_and_place_do_not_matter(seed: int, exponent: int):
    rng = np.random.default_rng(seed)
    points = np.round(rng.random((30, 3)) * 2**20) / 2**20
    expected = short_edge_triangles(points).faces
    np.testing.assert_array_equal(short_edge_triangles(points * 2.0**exponent).faces, expected)
    np.testing.assert_array_equal(short_edge_triangles(points + 1024.0).faces, expected)


def test_repeated_points():
    mesh = short_edge_triangles(np.repeat(BOX_POINTS, 5, axis=0))
    np.testing.assert_allclose(mesh.areas.sum(), short_edge_triangles(BOX_POINTS).areas.sum())


@pytest.mark.parametrize(
    "points",
    [np.zeros((1, 3)), np.eye(3)[:2], np.zeros((9, 3)), np.repeat(np.eye(3)[:2], 9, axis=0)],
)
def test_too_few_points_for_a_triangle(points: np.ndarray):
    with pytest.raises(GeometryError, match="no three points"):
        short_edge_triangles(points)
    cloud = PointCloud(points)
    assert fill_surface(cloud) is cloud


@pytest.mark.parametrize(("neighbours", "reach"), [(1, 2.0), (5, 0.0), (5, np.nan), (5, np.inf)])
def test_invalid_arguments_are_refused(neighbours: int, reach: float):
    with pytest.raises(InputError):
        short_edge_triangles(BOX_POINTS, neighbours, reach)


def test_a_far_point_and_a_dense_clump():
    """Distances of many scales: the cells are as large as the reach all the same."""
    rng = np.random.default_rng(4)
    clump, far = rng.random((300, 3)) * 1e-9, np.array([[1e3, 0, 0], [1e3, 1e-3, 0]])
    points = np.concatenate([BOX_POINTS, clump, far])
    expected = triangles_by_definition(points, 16, 1.9)
    assert set(map(tuple, short_edge_triangles(points).faces.tolist())) == expected


def test_kernels_refuse_indices_outside_their_arrays():
    for faces in ([[0, 1, 3]], [[-1, 0, 1]]):
        with pytest.raises(ValueError, match="vertices"):
            _native.face_normals(np.eye(3), np.array(faces))
    for kernel in (_native.spacing, lambda points: _native.short_edge_faces(points, 16, 1.9)):
        with pytest.raises(ValueError, match="two points"):
            kernel(np.zeros((1, 3)))
        with pytest.raises(TypeError):
            kernel(np.zeros((5, 2)))


def test_points_that_are_not_finite_are_refused():
    with pytest.raises(GeometryError, match="NaN"):
        short_edge_triangles([[0, 0, np.nan]] * 4)


def test_filling_adds_points_and_keeps_the_rest():
    normals = np.tile([0.0, 0.0, 1.0], (len(BOX_POINTS), 1))
    cloud = PointCloud(BOX_POINTS, normals_xyz=normals)
    filled = fill_surface(cloud, count=4000)
    assert len(filled) == len(cloud) + 4000
    np.testing.assert_array_equal(filled.points_xyz[: len(cloud)], BOX_POINTS)
    np.testing.assert_allclose(filled.weights @ filled.points_xyz, BOX_POINTS.mean(axis=0))
    assert (filled.points_xyz <= BOX_POINTS.max(axis=0) + 1e-12).all()
    assert (filled.points_xyz >= BOX_POINTS.min(axis=0) - 1e-12).all()
    np.testing.assert_allclose(filled.normals_xyz, np.tile([0, 0, 1], (len(filled), 1)))
    np.testing.assert_array_equal(filled.points_xyz, fill_surface(cloud, count=4000).points_xyz)
    weighted = fill_surface(PointCloud(BOX_POINTS, areas=np.arange(500.0)))
    np.testing.assert_array_equal(weighted.areas[:500], np.arange(500.0))


def test_every_model_of_modelnet_is_closed(data_folder: Path):
    """No model may be left with next to no triangles."""
    train = np.load(data_folder / "modelnet10" / "train.npz")
    counts = [len(short_edge_triangles(points).faces) for points in train["points_u16"][::40]]
    assert min(counts) > 1.5 * 1024
