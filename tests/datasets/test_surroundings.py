"""Rays against planes and boxes in closed form, and against Embree."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.surroundings import (
    BOX,
    FLOOR,
    MAX_RANGE_M,
    NOTHING,
    OBJECT,
    WALL,
    RoomBox,
    RoomSurroundings,
    Wall,
)
from circumspect.geometry import TriangleMesh
from circumspect.simulation.scene import block


def rays(seed, count=200):
    found = np.random.default_rng(seed).normal(size=(count, 3)).astype(np.float32)
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_rays_below_the_horizon_meet_the_floor_at_its_depth():
    found = RoomSurroundings().hits(np.array([0.0, 0.0, 2.0]), rays(0))
    down = rays(0)[:, 2] < 0
    assert (found.kind[down] == FLOOR).all()
    assert (found.kind[~down] == NOTHING).all()
    np.testing.assert_allclose(2.0 + found.depth[down] * rays(0)[down, 2], 0.0, atol=1e-3)


def test_a_wall_is_met_on_its_plane_and_hides_what_is_behind():
    wall = Wall(np.array([3.0, 0.0]), np.array([-1.0, 0.0]))
    origin = np.array([0.0, 0.0, 1.0])
    found = RoomSurroundings((wall,)).hits(origin, rays(1))
    on = found.kind == WALL
    assert on.any()
    np.testing.assert_allclose(found.depth[on] * rays(1)[on, 0], 3.0, rtol=1e-4)
    assert not wall.is_behind(origin)
    assert wall.is_behind(np.array([3.1, 0.0, 1.0]))


@settings(max_examples=30)
@given(
    seed=st.integers(0, 10_000),
    yaw=st.floats(0, np.pi),
    half=st.tuples(*[st.floats(0.05, 1.0)] * 3),
)
def test_a_box_is_met_where_embree_meets_its_mesh(seed, yaw, half):
    half = np.array(half)
    box = RoomBox(np.array([0.3, -0.2, 0.5]), half, yaw)
    mesh = block(tuple(-half), tuple(half))
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1.0]])
    placed = TriangleMesh(mesh.vertices_xyz @ turn.T + box.centre_xyz, mesh.faces)
    origin = np.array([4.0, 1.0, 2.0])
    aimed = rays(seed) * 0.4 + (box.centre_xyz - origin).astype(np.float32) / 4
    aimed = aimed.astype(np.float32)
    fast, slow = box.hits(origin, aimed), ObjectCaster(placed).hits(origin, aimed, np.ones(3))
    hit = (fast.kind == BOX) & (slow.kind == OBJECT)
    # Rays along an edge may be decided either way.
    assert ((fast.kind == BOX) != (slow.kind == OBJECT)).mean() < 0.02
    np.testing.assert_allclose(fast.depth[hit], slow.depth[hit], rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(fast.incidence[hit], slow.incidence[hit], atol=0.05)


@pytest.mark.parametrize("stretch", [(1.0, 1.0, 1.0), (1.3, 0.8, 1.1), (-1.2, 0.9, 1.0)])
def test_a_stretched_object_is_met_where_the_stretched_mesh_is(stretch):
    mesh = block((-0.2, -0.5, 0.0), (0.4, 0.3, 0.9))
    stretched = TriangleMesh(mesh.vertices_xyz * stretch, mesh.faces)
    origin = np.array([2.5, 0.7, 1.1])
    aimed = (rays(5) * 0.3 - (origin * 0.4)).astype(np.float32)
    fast = ObjectCaster(mesh).hits(origin, aimed, np.array(stretch))
    slow = ObjectCaster(stretched).hits(origin, aimed, np.ones(3))
    np.testing.assert_array_equal(fast.kind, slow.kind)
    hit = fast.kind == OBJECT
    assert hit.any()
    np.testing.assert_allclose(fast.depth[hit], slow.depth[hit], rtol=1e-4)
    np.testing.assert_allclose(fast.incidence[hit], slow.incidence[hit], atol=1e-3)
    assert (fast.depth[~hit] == MAX_RANGE_M).all()
