"""Laws of clouds and meshes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import shape_files
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud, TriangleMesh

seeds = st.integers(0, 2**32 - 1)


def random_similarity(rng: np.random.Generator) -> np.ndarray:
    matrix = np.eye(4)
    mirror = np.diag([1, 1, rng.choice([-1, 1])])
    matrix[:3, :3] = Rotation.random(rng=rng).as_matrix() @ mirror * rng.uniform(0.1, 10)
    matrix[:3, 3] = rng.normal(size=3)
    return matrix


def random_cloud(rng: np.random.Generator, count: int = 20) -> PointCloud:
    normals = rng.normal(size=(count, 3))
    return PointCloud(
        rng.normal(size=(count, 3)),
        areas=rng.random(count),
        normals_xyz=normals / np.linalg.norm(normals, axis=1, keepdims=True),
    )


def random_mesh(rng: np.random.Generator, faces: int = 12) -> TriangleMesh:
    return TriangleMesh(rng.normal(size=(20, 3)), rng.integers(0, 20, (faces, 3)))


def assert_same(one: PointCloud, other: PointCloud) -> None:
    for field in dataclasses.fields(PointCloud):
        a, b = getattr(one, field.name), getattr(other, field.name)
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9, err_msg=field.name)


@given(seed=seeds)
def test_moving_is_a_group_action(seed: int):
    rng = np.random.default_rng(seed)
    cloud, first, second = random_cloud(rng), random_similarity(rng), random_similarity(rng)
    assert_same(cloud.moved(np.eye(4)), cloud)
    assert_same(cloud.moved(first).moved(second), cloud.moved(second @ first))
    assert_same(cloud.moved(first).moved(np.linalg.inv(first)), cloud)


@given(seed=seeds)
def test_moving_keeps_shape(seed: int):
    rng = np.random.default_rng(seed)
    cloud, matrix = random_cloud(rng), random_similarity(rng)
    moved = cloud.moved(matrix)
    scale = np.cbrt(abs(np.linalg.det(matrix[:3, :3])))
    np.testing.assert_allclose(moved.weights, cloud.weights)
    np.testing.assert_allclose(moved.areas, cloud.areas * scale**2)
    np.testing.assert_allclose(np.linalg.norm(moved.normals_xyz, axis=1), 1)
    edges, moved_edges = (np.diff(c.points_xyz, axis=0) for c in (cloud, moved))
    lengths = np.linalg.norm(edges, axis=1)
    np.testing.assert_allclose(np.linalg.norm(moved_edges, axis=1), scale * lengths)
    # The angle between a normal and an edge stays.
    np.testing.assert_allclose(
        np.sum(moved_edges * moved.normals_xyz[1:], axis=1),
        scale * np.sum(edges * cloud.normals_xyz[1:], axis=1),
        atol=1e-9,
    )


@pytest.mark.parametrize(
    ("matrix", "word"),
    [
        (np.eye(3), "shape"),
        (np.diag([1.0, 1.0, 2.0, 1.0]), "alike in all directions"),
        (np.zeros((4, 4)), "last row"),
        (np.diag([0.0, 0.0, 0.0, 1.0]), "alike"),
        (np.full((4, 4), np.nan), "finite"),
        ([["a"]], "numbers"),
    ],
)
def test_only_similarities_are_accepted_as_motions(matrix: object, word: str):
    with pytest.raises(GeometryError, match=word):
        PointCloud(np.eye(3)).moved(matrix)


def test_weights_sum_to_one():
    for areas in (None, [0, 0, 0], [1, 2, 3], [1e-200, 2e-200, 3e-200], [1e200, 2e200, 1e300]):
        assert PointCloud(np.eye(3), areas=areas).weights.sum() == pytest.approx(1)
    np.testing.assert_allclose(PointCloud(np.eye(3), areas=[1, 0, 3]).weights, [0.25, 0, 0.75])


def test_arrays_are_read_only_and_not_shared():
    given_points = np.eye(3)
    cloud = PointCloud(given_points, areas=np.ones(3), normals_xyz=np.eye(3))
    given_points[:] = 7
    np.testing.assert_array_equal(cloud.points_xyz, np.eye(3))
    mesh = TriangleMesh(np.eye(3), np.array([[0, 1, 2]]))
    arrays = (cloud.points_xyz, cloud.areas, cloud.normals_xyz, mesh.vertices_xyz, mesh.faces)
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        cloud.areas = None


def test_a_view_of_writeable_memory_is_copied():
    memory = np.eye(3)
    view = memory[:]
    view.flags.writeable = False
    cloud = PointCloud(view)
    memory[:] = 7
    np.testing.assert_array_equal(cloud.points_xyz, np.eye(3))


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"points_xyz": np.zeros((3, 2))}, r"shape \(n, 3\), not \(3, 2\)"),
        ({"points_xyz": np.zeros(3)}, r"not \(3,\)"),
        ({"points_xyz": np.zeros((0, 3))}, "no points"),
        ({"points_xyz": "chair"}, "numbers"),
        ({"points_xyz": [[1, 2, 3], [4, 5]]}, "numbers"),
        ({"points_xyz": [[0, 0, np.nan], [0, 0, 0]]}, "1 of 2 points are NaN"),
        ({"points_xyz": [[0, 0, np.inf], [np.inf, 0, 0]]}, "2 of 2 points are NaN"),
        ({"points_xyz": [[1e101, 0, 0]]}, "beyond 1e"),
        ({"points_xyz": np.eye(3), "areas": [1, 2]}, r"areas must have shape \(3,\), not \(2,\)"),
        ({"points_xyz": np.eye(3), "areas": [1, 2, np.nan]}, "areas holds NaN"),
        ({"points_xyz": np.eye(3), "areas": [1, 2, -1]}, "negative"),
        ({"points_xyz": np.eye(3), "normals_xyz": np.eye(2)}, "normals_xyz must have shape"),
    ],
)
def test_bad_clouds(arguments: dict, word: str):
    with pytest.raises(GeometryError, match=word):
        PointCloud(**arguments)


@pytest.mark.parametrize(
    ("vertices", "faces", "word"),
    [
        (np.eye(3), np.zeros((0, 3), int), "no faces"),
        (np.zeros((0, 3)), [[0, 0, 0]], "no vertices"),
        (np.eye(3), [[0, 1, 3]], "outside 0 … 2"),
        (np.eye(3), [[0, 1, -1]], "outside 0 … 2"),
        (np.eye(3), [[0, 1]], "shape"),
        (np.eye(3), [[0.0, 1.0, 2.0]], "whole numbers"),
        (np.eye(3) * np.nan, [[0, 1, 2]], "3 of 3 vertices are NaN"),
    ],
)
def test_bad_meshes(vertices: object, faces: object, word: str):
    with pytest.raises(GeometryError, match=word):
        TriangleMesh(vertices, faces)


@given(seed=seeds)
def test_areas_and_normals_are_those_of_the_cross_product(seed: int):
    mesh = random_mesh(np.random.default_rng(seed), faces=40)
    a, b, c = np.moveaxis(mesh.corners_xyz, 1, 0)
    spans = np.cross(b - a, c - a)
    lengths = np.linalg.norm(spans, axis=1)
    np.testing.assert_allclose(mesh.areas, 0.5 * lengths, atol=1e-14)
    units = spans[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    assert (mesh.sampled(500, seed).normals_xyz @ units.T).max(axis=1).min() > 1 - 1e-9


@given(seed=seeds, exponent=st.integers(-12, 12))
def test_areas_grow_with_the_square_of_the_scale(seed: int, exponent: int):
    mesh = random_mesh(np.random.default_rng(seed))
    scaled = TriangleMesh(mesh.vertices_xyz * 10.0**exponent, mesh.faces)
    np.testing.assert_allclose(scaled.areas, mesh.areas * 10.0 ** (2 * exponent), rtol=1e-9)


@given(seed=seeds, exponent=st.sampled_from([-150, -12, 0, 12, 90]))
def test_samples_lie_in_their_triangles(seed: int, exponent: int):
    rng = np.random.default_rng(seed)
    mesh = random_mesh(rng, faces=1 + int(rng.integers(5)))
    if mesh.areas.max() < 1e-6:
        return
    scale = 10.0**exponent
    cloud = TriangleMesh(mesh.vertices_xyz * scale, mesh.faces).sampled(50, rng)
    corners = mesh.corners_xyz[mesh.areas > 0]
    origin, edges = corners[:, 0], np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2)
    # Barycentric coordinates of each point in each triangle.
    offsets = cloud.points_xyz[:, None, :] / scale - origin
    shares = np.einsum("fij,pfj->pfi", np.linalg.pinv(edges), offsets)
    left = offsets - np.einsum("fji,pfi->pfj", edges, shares)
    inside = (shares > -1e-6).all(-1) & (shares.sum(-1) < 1 + 1e-6)
    assert (inside & (np.linalg.norm(left, axis=-1) < 1e-6)).any(axis=1).all()
    np.testing.assert_allclose(np.linalg.norm(cloud.normals_xyz, axis=1), 1)


def test_samples_are_proportional_to_area():
    """Stratified sampling gives each triangle its share to within one point at either end."""
    rng = np.random.default_rng(3)
    mesh = TriangleMesh(rng.normal(size=(120, 3)), np.arange(120).reshape(40, 3))
    cloud = mesh.sampled(10_000, rng)
    a, b, c = np.moveaxis(mesh.corners_xyz, 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    counts = [(np.abs(cloud.normals_xyz - normal).max(axis=1) < 1e-9).sum() for normal in normals]
    assert sum(counts) == 10_000
    np.testing.assert_allclose(counts, mesh.areas / mesh.areas.sum() * 10_000, rtol=0, atol=2)


def test_samples_are_even_within_a_triangle():
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.array([[0, 1, 2]]))
    points = mesh.sampled(40_000, 0).points_xyz
    np.testing.assert_allclose(points.mean(axis=0), [1 / 3, 1 / 3, 0], atol=0.005)
    # The four triangles between the middles of the sides are of one size.
    parts = [(points[:, 0] > 0.5), (points[:, 1] > 0.5), (points.sum(axis=1) < 0.5)]
    np.testing.assert_allclose([part.mean() for part in parts], 0.25, atol=0.01)


def test_sampling_skips_triangles_without_area():
    vertices = np.vstack([np.eye(3), np.eye(3)[0]])
    mesh = TriangleMesh(vertices, np.array([[0, 3, 3], [0, 1, 2], [1, 1, 1], [0, 0, 2]]))
    cloud = mesh.sampled(1000)
    np.testing.assert_allclose(cloud.normals_xyz, 1 / np.sqrt(3))
    flat = TriangleMesh(vertices, np.array([[0, 3, 3], [1, 1, 1]]))
    with pytest.raises(GeometryError, match="no area"):
        flat.sampled(10)
    with pytest.raises(GeometryError, match="at least 1 point"):
        mesh.sampled(0)


def test_sampling_covers_the_surface():
    mesh = TriangleMesh(shape_files.VERTICES, shape_files.FACES)
    probe = mesh.sampled(2000, 1).points_xyz
    distance, _ = KDTree(mesh.sampled(20_000, 2).points_xyz).query(probe)
    assert distance.max() < 0.15


@given(st.floats(-10, 10), st.floats(-10, 10))
def test_rotations_about_the_vertical_add_up(first, second):
    cloud = PointCloud(np.array([[1.0, 0.0, 2.0], [0.0, 3.0, -1.0]]), areas=np.array([1.0, 2.0]))
    both = cloud.turned(first).turned(second)
    np.testing.assert_allclose(both.points_xyz, cloud.turned(first + second).points_xyz, atol=1e-9)
    expected = Rotation.from_rotvec([0.0, 0.0, first]).apply(cloud.points_xyz.copy())
    np.testing.assert_allclose(cloud.turned(first).points_xyz, expected, atol=1e-12)
    np.testing.assert_allclose(both.areas, cloud.areas)


@pytest.mark.parametrize("yaw", [np.nan, np.inf])
def test_a_rotation_that_is_not_finite_is_refused(yaw):
    with pytest.raises(GeometryError, match="finite"):
        PointCloud(np.eye(3)).turned(yaw)
