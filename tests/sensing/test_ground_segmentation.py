from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.sensing import DepthNoise, GroundSegmentation, RgbdFrame
from circumspect.simulation import (
    Orbit,
    Scene,
    SimulatedCamera,
    Station,
    Surface,
    block,
    looking_at,
)

CAMERA = PinholeCamera.xtion()
SEGMENTATION = GroundSegmentation()
OBJECT = 0


def shots(
    mesh: TriangleMesh, *others: Surface, count: int = 4, start: float = 0.4, noisy: bool = True
) -> Iterator[tuple[RgbdFrame, np.ndarray]]:
    """(frame, true object pixels) of `count` frames round an object."""
    orbit = Orbit.around(mesh, CAMERA, start=start)
    scene = Scene.with_object(mesh, *others)
    noise = DepthNoise() if noisy else None
    camera = SimulatedCamera(scene, orbit.stations(count).__next__, CAMERA, noise)
    for index in range(count):
        frame = camera.capture()
        truth = camera.truth(orbit.station(2 * np.pi * index / count))
        yield frame, (truth.surface == OBJECT) & frame.valid


def scores(mask: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    """Precision and recall."""
    both = float((mask & truth).sum())
    return both / max(mask.sum(), 1), both / max(truth.sum(), 1)


@pytest.mark.parametrize("category", CATEGORIES)
def test_finds_furniture_on_the_floor(category: str) -> None:
    mesh = make_furniture(category, 5)
    known = make_known(mesh)
    for frame, truth in shots(mesh, count=3):
        # From one view, occluded parts may seem separate until the object is known.
        precision, recall = scores(SEGMENTATION.object_mask(frame), truth)
        assert precision > 0.99
        assert recall > 0.75
        precision, recall = scores(SEGMENTATION.object_mask(frame, known), truth)
        assert precision > 0.99
        assert recall > 0.93


@pytest.mark.parametrize("category", ["chair", "table"])
def test_a_wall_behind_and_clutter_beside_are_not_part_of_the_object(category: str) -> None:
    mesh = make_furniture(category, 5)
    reach = float(np.hypot(*mesh.vertices_xyz[:, :2].T).max())
    far = reach + 2.2
    wall = Surface("wall", block((-far - 0.1, -9, 0), (-far, 9, 2.6)))
    low = mesh.vertices_xyz.min(axis=0)
    clutter = Surface("clutter", block((-0.2, low[1] - 0.45, 0), (0.1, low[1] - 0.2, 0.4)))
    known = None
    for frame, truth in shots(mesh, wall, clutter, count=6, start=0.0):
        mask = SEGMENTATION.object_mask(frame, known)
        precision, recall = scores(mask, truth)
        assert precision > 0.98
        assert recall > 0.85
        points = frame.points_map(mask)
        known = points if known is None else np.concatenate([known, points])


@pytest.mark.parametrize("yaw_deg", [-40.0, 0.0, 25.0])
@pytest.mark.parametrize("away", [0.9, 1.5, 2.5])
def test_a_wall_is_no_object(away: float, yaw_deg: float) -> None:
    """Of it neither the upper end is in the picture nor both sides are."""
    frame = one_frame(yaw_deg, wall_at(away))
    assert (frame.depth < 3.0).mean() > 0.3
    assert not SEGMENTATION.object_mask(frame).any()


def test_a_wall_nearer_to_the_centre_than_the_object_is_skipped() -> None:
    """A box at the rim, and a wall that is nearer than it."""
    box = Surface("object", block((1.3, 0.45, 0), (1.6, 0.75, 0.5)))
    screen = Surface("wall", block((1.0, -9, 0), (1.1, 0.1, 2.6)))
    frame = one_frame(0.0, box, screen)
    points = frame.points_map(SEGMENTATION.object_mask(frame))
    assert len(points) > 1000
    assert points[:, 0].min() > 1.25
    assert points[:, 0].max() < 1.65


def wall_at(away: float) -> Surface:
    return Surface("wall", block((away, -9, 0), (away + 0.1, 9, 2.6)))


def one_frame(yaw_deg: float, *surfaces: Surface) -> RgbdFrame:
    """From 1.2 m above the floor, looking down a little."""
    yaw, floor = np.radians(yaw_deg), Surface("floor", block((-9, -9, -0.1), (9, 9, 0.0)))
    station = Station(0.0, looking_at((0.0, 0.0, 1.2), (np.cos(yaw), np.sin(yaw), 0.7)))
    return SimulatedCamera(
        Scene((*surfaces, floor)), lambda: station, CAMERA, DepthNoise()
    ).capture()


def test_a_known_object_is_kept_although_another_one_is_nearer() -> None:
    mesh = block((-0.2, -0.2, 0), (0.2, 0.2, 0.5))
    in_front = Surface("clutter", block((0.42, -0.15, 0), (0.46, 0.15, 0.3)))
    frame, truth = next(shots(mesh, in_front, count=1, start=0.0))
    known = make_known(mesh)
    alone = SEGMENTATION.object_mask(frame)
    assert scores(alone, truth)[0] < 0.1, "where nothing is known the nearer one is taken"
    precision, recall = scores(SEGMENTATION.object_mask(frame, known), truth)
    assert precision > 0.99
    assert recall > 0.9


def make_known(mesh: TriangleMesh) -> np.ndarray:
    return mesh.sampled(3000).points_xyz


def test_an_object_known_elsewhere_is_not_in_view() -> None:
    mesh = block((-0.2, -0.2, 0), (0.2, 0.2, 0.5))
    frame, _ = next(shots(mesh, count=1))
    known = make_known(mesh) + np.array([5.0, 0.0, 0.0])
    assert not SEGMENTATION.object_mask(frame, known).any()


def test_bare_floor_has_no_object() -> None:
    mesh = block((-0.2, -0.2, -0.5), (0.2, 0.2, -0.1))
    for frame, _ in shots(mesh, count=2):
        assert not SEGMENTATION.object_mask(frame).any()


@pytest.mark.parametrize(
    ("raised", "tilted_deg"), [(0.02, 0.0), (-0.02, 0.0), (0.0, 0.5), (0.01, -0.4)]
)
def test_a_slightly_wrong_pose_does_not_include_the_floor(raised: float, tilted_deg: float) -> None:
    frame, truth = next(shots(make_furniture("toilet", 5), count=1))
    wrong = RigidTransform.from_components(
        [0, 0, raised], Rotation.from_euler("x", tilted_deg, degrees=True)
    )
    precision, recall = scores(SEGMENTATION.object_mask(frame.at(wrong * frame.pose)), truth)
    assert precision > 0.98
    assert recall > 0.9


def test_flying_pixels_do_not_belong_to_the_object() -> None:
    frame, _ = next(shots(make_furniture("chair", 5), count=1, noisy=False))
    mask = SEGMENTATION.object_mask(frame)
    rim = mask[:, :-1] & ~mask[:, 1:] & frame.valid[:, 1:]
    v, u = np.nonzero(rim)
    depth = frame.depth.copy()
    between = depth[v, u + 1] > depth[v, u] + 0.3
    v, u = v[between], u[between]
    assert len(v) > 100
    depth[v, u + 1] = (depth[v, u] + depth[v, u + 1]) / 2
    flying = RgbdFrame(depth, CAMERA, 0.0, frame.pose)
    assert SEGMENTATION.object_mask(flying)[v, u + 1].mean() < 0.05


def test_a_frame_without_depth_has_no_object() -> None:
    nothing = np.full((480, 640), np.nan)
    frame = RgbdFrame(nothing, CAMERA, 0.0, RigidTransform.identity())
    assert not SEGMENTATION.object_mask(frame).any()


def test_a_frame_without_a_pose_is_refused() -> None:
    with pytest.raises(InputError, match="no pose"):
        SEGMENTATION.object_mask(RgbdFrame(np.ones((480, 640)), CAMERA, 0.0))


@pytest.mark.parametrize("wrong", [{"cell": 0.0}, {"cell": 1e-4}, {"min_pixels": 0}])
def test_invalid_settings_are_refused(wrong):
    with pytest.raises(InputError, match=r"cell must be|min_pixels must be"):
        GroundSegmentation(**wrong)
