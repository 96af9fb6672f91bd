from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import CAMERA, T_BASE_CAMERA, short_drive

from circumspect.mapping.scene_map import SceneMap
from circumspect.mapping.visibility import seen_through


def known(points_xyz: np.ndarray, T_map_camera: RigidTransform) -> SceneMap:
    """A map of points that face a camera."""
    facing = T_map_camera.translation - points_xyz
    normals = facing / np.linalg.norm(facing, axis=1, keepdims=True)
    scene = SceneMap(0.03)
    object.__setattr__(scene, "points_xyz", points_xyz)
    object.__setattr__(scene, "normals_xyz", normals)
    return scene


def upright(depth: np.ndarray):
    return replace(short_drive()[0], depth=depth)


def at(u: np.ndarray, v: np.ndarray, z: float, T: RigidTransform) -> np.ndarray:
    x, y = (u - CAMERA.cx) / CAMERA.fx * z, (v - CAMERA.cy) / CAMERA.fy * z
    return T.apply(np.stack([x, y, np.full(len(x), z)], axis=1))


@pytest.mark.parametrize(("gap_m", "through"), [(0.03, False), (0.12, True)])
def test_between_thin_parts_nothing_is_seen_through(gap_m: float, through: bool) -> None:
    """Rungs 1 m away; the map has points in the middle of their gaps, where voxels meet."""
    rung, gap = 4, round(gap_m * CAMERA.fx)
    column = np.arange(CAMERA.width) % (rung + gap)
    depth = np.where(column < rung, 1.0, 2.5) * np.ones((CAMERA.height, 1))
    middle = np.flatnonzero(column == rung + gap // 2)
    u, v = (grid.ravel() for grid in np.meshgrid(middle[1:-1], np.arange(30, 60)))
    scene = known(at(u, v, 1.0, T_BASE_CAMERA), T_BASE_CAMERA)
    assert seen_through(upright(depth), scene, T_BASE_CAMERA) == float(through)


def test_a_surface_that_is_not_there_is_seen_through_up_to_its_rim() -> None:
    u, v = (grid.ravel() for grid in np.meshgrid(np.arange(60, 180, 3), np.arange(20, 100, 3)))
    scene = known(at(u, v, 1.0, T_BASE_CAMERA), T_BASE_CAMERA)
    there = np.full((CAMERA.height, CAMERA.width), 1.0)
    assert seen_through(upright(there), scene, T_BASE_CAMERA) == 0
    assert seen_through(upright(there + 1), scene, T_BASE_CAMERA) == 1
    moved = there.copy()
    moved[:, :90] = 2.0  # a quarter of what is known
    assert 0.15 < seen_through(upright(moved), scene, T_BASE_CAMERA) < 0.25
