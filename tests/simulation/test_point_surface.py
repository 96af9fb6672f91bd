from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.datasets.farthest_points import evenly_sampled
from circumspect.errors import GeometryError, InputError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.simulation import Orbit, RayCaster, Scene, Surface, surface_from_points
from circumspect.simulation.point_surface import LONGEST_SIDES_M

CAMERA = PinholeCamera(96, 72, 85.0, 85.0, 47.5, 35.5)


@pytest.mark.parametrize("category", ["night_stand", "table", "toilet"])
def test_a_reconstructed_surface_renders_like_the_true_one(category: str) -> None:
    true = make_furniture(category, 2)
    rebuilt = surface_from_points(evenly_sampled(true, 2), category)
    scale = np.ptp(true.vertices_xyz, axis=0).max() / np.ptp(rebuilt.vertices_xyz, axis=0).max()
    rebuilt = TriangleMesh(rebuilt.vertices_xyz * scale, rebuilt.faces)
    orbit = Orbit.around(true, PinholeCamera.xtion())
    through, hits, errors = 0, 0, []
    for angle in np.arange(4) * np.pi / 2 + 0.2:
        a, b = (depth(mesh, orbit, float(angle)) for mesh in (true, rebuilt))
        hit, both = np.isfinite(a), np.isfinite(a) & np.isfinite(b)
        hits += hit.sum()
        through += (hit & ~both).sum() + (b - a > 0.05)[both].sum()
        errors.append(np.abs(b - a)[both])
    assert through / hits < 0.08
    assert np.median(np.concatenate(errors)) < 0.006


def depth(mesh: TriangleMesh, orbit: Orbit, angle: float) -> np.ndarray:
    caster = RayCaster(Scene((Surface("object", mesh),)))
    return caster.view(CAMERA, orbit.station(angle).T_map_camera).depth


def test_triangles_that_smaller_ones_cover_are_left_out_without_a_hole() -> None:
    rng = np.random.default_rng(4)
    grid = np.stack(np.meshgrid(*[np.arange(20.0)] * 2), axis=-1).reshape(-1, 2)
    points = np.column_stack([grid + rng.uniform(-0.2, 0.2, grid.shape), np.zeros(400)])
    rebuilt = surface_from_points(points, "table")
    assert len(rebuilt.faces) < 5 * len(points)  # all triangles: 10
    caster = RayCaster(Scene((Surface("object", rebuilt),)))
    down = RigidTransform.from_components([0, 0, 1], Rotation.from_euler("x", np.pi))
    within = PinholeCamera(96, 96, 96.0, 96.0, 47.5, 47.5)
    assert np.isfinite(caster.view(within, down).depth).all()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 5e4])
def test_the_unit_of_the_points_does_not_matter(scale: float) -> None:
    points = evenly_sampled(make_furniture("chair", 1)).astype(np.float64)
    one, other = (surface_from_points(p, "chair") for p in (points, points * scale + 7 * scale))
    np.testing.assert_allclose(one.vertices_xyz, other.vertices_xyz, atol=1e-6)
    low, high = one.vertices_xyz.min(axis=0), one.vertices_xyz.max(axis=0)
    np.testing.assert_allclose(low[:2], -high[:2], atol=1e-9)
    assert low[2] == 0
    assert (high - low).max() == pytest.approx(0.9)


def test_every_category_of_the_furniture_has_a_plausible_size() -> None:
    assert tuple(sorted(LONGEST_SIDES_M)) == CATEGORIES
    for category, longest in LONGEST_SIDES_M.items():
        sides = [np.ptp(make_furniture(category, s).vertices_xyz, axis=0).max() for s in range(30)]
        assert min(sides) <= longest <= max(sides)


def test_objects_of_the_training_pack_become_surfaces(data_folder: Path) -> None:
    with np.load(data_folder / "modelnet10" / "train.npz", allow_pickle=False) as pack:
        points, labels, classes = pack["points_u16"], pack["labels"], pack["classes"]
    for label, category in enumerate(classes.tolist()):
        mesh = surface_from_points(points[np.flatnonzero(labels == label)[7]], category)
        assert np.ptp(mesh.vertices_xyz, axis=0).max() == pytest.approx(LONGEST_SIDES_M[category])
        assert len(mesh.faces) > 2000


def test_an_unknown_category_is_named_with_those_there_are() -> None:
    with pytest.raises(InputError, match="'chiar'; known: bathtub"):
        surface_from_points(np.eye(3), "chiar")


@pytest.mark.parametrize("points", [np.zeros((5, 3)), np.full((9, 3), np.nan), np.empty((0, 3))])
def test_points_without_a_surface_are_refused(points: np.ndarray) -> None:
    with pytest.raises(GeometryError):
        surface_from_points(points, "chair")
