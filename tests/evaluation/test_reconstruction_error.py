from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.errors import CircumspectError, InputError
from circumspect.evaluation.reconstruction_error import (
    reconstruction_error,
    surface_distances,
    visible_surface,
)
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.sensing import DepthNoise
from circumspect.simulation import Scene, Surface, block, looking_at

HALF = np.array([0.2, 0.3, 0.4])
BOX = block((-0.2, -0.3, 0.0), (0.2, 0.3, 0.8))
CAMERA = PinholeCamera(160, 120, 142.0, 142.0, 79.5, 59.5)


def box_distance(points: np.ndarray) -> np.ndarray:
    """To the surface of `BOX`, from in- and outside."""
    over = np.abs(points - [0, 0, 0.4]) - HALF
    outside = np.linalg.norm(np.maximum(over, 0), axis=1)
    return np.where((over < 0).all(axis=1), -over.max(axis=1), outside)


def round_trip(count: int = 8, radius: float = 1.6) -> list:
    """Poses all round the box."""
    angles = np.arange(count) * 2 * np.pi / count
    return [looking_at((radius * np.cos(a), radius * np.sin(a), 1.4), (0, 0, 0.4)) for a in angles]


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_distances_to_a_box_are_never_too_small_and_nearly_always_exact(seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-1, 1.2, (50, 3))
    np.testing.assert_allclose(surface_distances(points, BOX), box_distance(points), atol=2e-3)
    near = BOX.sampled(50, seed).points_xyz + np.random.default_rng(seed).normal(0, 0.01, (50, 3))
    excess = surface_distances(near, BOX) - box_distance(near)
    # Beside an edge the triangle round the corner may not be among those tried.
    assert (excess > -1e-9).all()
    assert (excess < 1e-6).mean() >= 0.9
    assert excess.max() < 2e-3


def test_faces_without_area_are_no_trouble() -> None:
    flat = TriangleMesh(
        np.vstack([BOX.vertices_xyz, [[5.0, 5, 5]]]), np.vstack([BOX.faces, [[8, 8, 8]]])
    )
    assert surface_distances(np.array([[5.0, 5, 5]]), flat)[0] > 5


def test_visible_points_lie_on_the_surface_evenly_and_cover_all_sides_but_the_underside() -> None:
    visible = visible_surface(Scene.with_object(BOX), CAMERA, round_trip(), spacing=0.02)
    assert box_distance(visible).max() < 1e-5
    for axis, sign in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1)]:
        face = np.abs(visible[:, axis] - [0, 0, 0.4][axis] - sign * HALF[axis]) < 1e-4
        area = 4 * np.prod(np.delete(HALF, axis))
        assert face.sum() == pytest.approx(area / 0.02**2, rel=0.15)
    assert visible[:, 2].min() > -1e-5
    assert (np.abs(visible[:, :2]).max(axis=1) < 0.19)[visible[:, 2] < 0.01].sum() == 0


def test_hidden_points_and_points_out_of_range_are_not_visible() -> None:
    front = [looking_at((1.6, 0, 0.9), (0, 0, 0.4))]
    wall = Surface("wall", block((0.5, -2, 0), (0.6, 2, 0.4)))
    free = visible_surface(Scene.with_object(BOX), CAMERA, front)
    assert free[:, 0].min() >= -0.2 - 1e-6
    assert (np.abs(free[:, 0] - 0.2) < 1e-4).sum() > 1000
    hidden = visible_surface(Scene.with_object(BOX, wall), CAMERA, front)
    assert hidden[:, 2].min() > 0.2
    assert 0 < len(hidden) < len(free)
    near = DepthNoise(farthest=1.0)
    assert len(visible_surface(Scene.with_object(BOX), CAMERA, front, sensor=near)) == 0


def test_grazed_surfaces_are_not_visible() -> None:
    level = [looking_at((1.6, 0, 0.85), (0, 0, 0.4))]
    visible = visible_surface(Scene.with_object(BOX), CAMERA, level)
    assert (visible[:, 2] > 0.8 - 1e-4).sum() < 50  # The top, at some 88 degrees.


def test_a_perfect_model_has_no_error_but_its_spacing() -> None:
    visible = visible_surface(Scene.with_object(BOX), CAMERA, round_trip())
    error = reconstruction_error(visible, BOX, visible)
    assert error.completion_m == 0
    assert error.accuracy_m < 1e-6
    assert error.completeness == 1
    coarse = visible[np.unique(np.floor(visible / 0.02 + 0.3), axis=0, return_index=True)[1]]
    error = reconstruction_error(coarse, BOX, visible)
    assert 0.004 < error.completion_m < 0.01
    assert 0.5 < error.completeness < 1


@given(st.floats(0.001, 0.05), st.floats(0.002, 0.04))
@settings(max_examples=20)
def test_a_swollen_model_is_off_by_as_much(swelling: float, threshold: float) -> None:
    cloud = BOX.sampled(5000)
    assert cloud.normals_xyz is not None
    swollen = cloud.points_xyz + swelling * cloud.normals_xyz
    error = reconstruction_error(swollen, BOX, cloud.points_xyz, threshold)
    assert error.accuracy_m == pytest.approx(swelling, abs=1e-6)
    assert error.completion_m <= swelling + 1e-9
    assert error.chamfer_m == pytest.approx((error.accuracy_m + error.completion_m) / 2)
    assert error.completeness >= (swelling < threshold - 1e-9)


def test_half_a_model_is_half_complete_but_accurate() -> None:
    points = BOX.sampled(40_000).points_xyz
    error = reconstruction_error(points[points[:, 0] > 0], BOX, points)
    assert error.completeness == pytest.approx(0.5, abs=0.03)
    assert error.whole_completeness == pytest.approx(0.5, abs=0.03)
    assert error.accuracy_m < 1e-6
    assert error.completion_m > 0.02
    assert (error.model_points, error.visible_points) == ((points[:, 0] > 0).sum(), 40_000)


@pytest.mark.parametrize(
    ("model", "visible", "threshold", "word"),
    [
        (np.empty((0, 3)), np.ones((4, 3)), 0.01, "the model has no points"),
        (np.ones((4, 3)), np.empty((0, 3)), 0.01, "visible part of the true surface has no points"),
        (np.ones((4, 2)), np.ones((4, 3)), 0.01, r"shape \(n, 3\), not \(4, 2\)"),
        (np.full((4, 3), np.nan), np.ones((4, 3)), 0.01, "NaN"),
        (np.ones((4, 3)), np.ones((4, 3)), 0.0, "must be positive"),
    ],
)
def test_bad_input(model: np.ndarray, visible: np.ndarray, threshold: float, word: str) -> None:
    with pytest.raises(CircumspectError, match=word):
        reconstruction_error(model, BOX, visible, threshold)


def test_an_unknown_surface_is_named() -> None:
    with pytest.raises(InputError, match="no surface 'objct' in the scene; known: object, floor"):
        visible_surface(Scene.with_object(BOX), CAMERA, round_trip(1), name="objct")


def test_hidden_parts_lower_the_completeness_of_the_whole_surface_alone() -> None:
    points = BOX.sampled(40_000).points_xyz
    visible = points[points[:, 2] > points[:, 2].min() + 1e-6]  # All but the underside.
    error = reconstruction_error(visible, BOX, visible)
    assert error.completeness == 1
    assert 0.5 < error.whole_completeness < 0.95
