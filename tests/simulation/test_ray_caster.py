from __future__ import annotations

import sys

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import MissingExtraError
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.simulation import RayCaster, Scene, Surface, View, block, floor, looking_at

CAMERA = PinholeCamera(96, 72, 80.0, 84.0, 47.5, 35.5)


def seen(mesh: TriangleMesh, pose: RigidTransform) -> View:
    return RayCaster(Scene((Surface("thing", mesh),))).view(CAMERA, pose)


def rays_in_map(pose: RigidTransform) -> np.ndarray:
    return CAMERA.rays_xyz @ pose.rotation.as_matrix().T


@settings(max_examples=25)
@given(height=st.floats(0.3, 3.0), pitch=st.floats(-1.5, 0.6), azimuth=st.floats(0, 6.3))
def test_depth_and_incidence_of_a_plane(height: float, pitch: float, azimuth: float) -> None:
    ahead = [np.cos(azimuth), np.sin(azimuth), height + np.sin(pitch)]
    pose = looking_at([0, 0, height], ahead)
    view = seen(floor(400.0), pose)
    rays = rays_in_map(pose)
    with np.errstate(divide="ignore"):
        depth = -height / rays[..., 2]
    depth[(depth < 0) | (depth > 300)] = np.nan
    known = np.isfinite(depth)
    assert np.isfinite(view.depth[known]).all()
    np.testing.assert_allclose(view.depth[known], depth[known], rtol=2e-4)
    cosine = -rays[..., 2] / np.linalg.norm(rays, axis=-1)
    np.testing.assert_allclose(np.cos(view.incidence[known]), cosine[known], atol=1e-4)
    assert np.isnan(view.depth[rays[..., 2] > 0]).all()
    assert (view.surface[rays[..., 2] > 0] == -1).all()


def test_depth_of_a_sphere_between_its_facets_and_itself() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=5, radius=0.5)
    mesh = TriangleMesh(sphere.vertices, sphere.faces)
    pose = looking_at([1.7, -0.4, 0.6], [0, 0, 0])
    view = seen(mesh, pose)
    rays, origin = rays_in_map(pose), pose.translation
    # |o + t r|² = 0.25
    a, b, c = (rays**2).sum(-1), 2 * rays @ origin, origin @ origin - 0.25
    inside = b**2 - 4 * a * c
    depth = np.where(inside > 0, (-b - np.sqrt(np.maximum(inside, 0))) / (2 * a), np.nan)
    firmly = inside > 0.05
    # Facets lie at most this far below the sphere; a slanting ray goes further.
    edge = float(sphere.edges_unique_length.max())
    sag = 0.5 - np.sqrt(0.25 - edge**2 / 3)
    error = view.depth - depth
    assert error[firmly].min() > -1e-6
    assert (error * np.cos(view.incidence))[firmly].max() < 1.5 * sag
    assert np.isnan(view.depth[inside < -0.05]).all()


@settings(max_examples=25)
@given(azimuth=st.floats(0, 6.28), height=st.floats(0.1, 2.0))
def test_depth_of_a_box_equals_the_slab_method(azimuth: float, height: float) -> None:
    low, high = np.array([-0.3, -0.2, 0.0]), np.array([0.4, 0.5, 0.8])
    pose = looking_at([2 * np.cos(azimuth), 2 * np.sin(azimuth), height], [0, 0, 0.4])
    view = seen(block(tuple(low), tuple(high)), pose)
    rays, origin = rays_in_map(pose), pose.translation
    with np.errstate(divide="ignore"):
        one, other = (low - origin) / rays, (high - origin) / rays
    enter = np.minimum(one, other).max(-1)
    leave = np.maximum(one, other).min(-1)
    hit = (enter < leave) & (enter > 0)
    clearly = np.abs(enter - leave) > 1e-3
    assert (np.isfinite(view.depth) == hit)[clearly].all()
    np.testing.assert_allclose(view.depth[hit & clearly], enter[hit & clearly], rtol=1e-4)


def test_the_first_surface_hides_those_behind_and_is_named() -> None:
    near, far = block((1, -0.2, -0.2), (1.1, 0.2, 0.2)), block((2, -3, -3), (2.1, 3, 3))
    caster = RayCaster(Scene((Surface("far", far), Surface("near", near))))
    view = caster.view(CAMERA, looking_at([0, 0, 0], [1, 0, 0]))
    assert view.surface[36, 48] == 1
    np.testing.assert_allclose(view.depth[view.surface == 1], 1.0, rtol=1e-5)
    np.testing.assert_allclose(view.depth[view.surface == 0], 2.0, rtol=1e-5)
    assert (view.surface == 0).any()


def test_both_sides_of_a_triangle_are_seen() -> None:
    corners = np.array([[1.0, -5, -5], [1, 5, -5], [1, 0, 9]])
    pose = looking_at([0, 0, 0], [1, 0, 0])
    for faces in ([[0, 1, 2]], [[0, 2, 1]]):
        assert seen(TriangleMesh(corners, np.array(faces)), pose).depth[36, 48] == pytest.approx(
            1.0
        )


def test_a_turned_scene_seen_from_the_turned_place_looks_the_same() -> None:
    turn = RigidTransform.from_components(
        [3.0, -2.0, 1.0], Rotation.from_euler("z", 40, degrees=True)
    )
    mesh = block((-0.3, -0.2, 0.0), (0.4, 0.5, 0.8))
    turned = TriangleMesh(turn.apply(mesh.vertices_xyz), mesh.faces)
    pose = looking_at([1.5, 0.7, 1.0], [0, 0, 0.4])
    here, there = seen(mesh, pose).depth, seen(turned, turn * pose).depth
    assert (np.isfinite(here) != np.isfinite(there)).mean() < 1e-3
    both = np.isfinite(here) & np.isfinite(there)
    assert np.quantile(np.abs(here - there)[both], 0.999) < 1e-4


def test_the_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)
    monkeypatch.setitem(sys.modules, "embreex.mesh_construction", None)
    with pytest.raises(MissingExtraError, match=r'pip install "circumspect\[sim\]"'):
        RayCaster(Scene.with_object(floor(1.0)))
