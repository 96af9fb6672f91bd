"""Furniture beside an object: rays meet it, and its near parts may be merged into the object."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.placed_object import Neighbour
from circumspect.datasets.scan_augmentation import CHANCES, ScanAugmentation
from circumspect.datasets.surroundings import FURNITURE, NOTHING, RoomSurroundings
from circumspect.furniture import make_furniture
from circumspect.geometry import TriangleMesh

LOW, HIGH = np.array([-0.4, -0.3, 0.0]), np.array([0.5, 0.3, 0.7])


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_a_neighbour_is_met_where_its_mesh_stands(seed):
    rng = np.random.default_rng(seed)
    piece = Neighbour.drawn(LOW, HIGH, rng)
    cosine, sine = np.cos(piece.yaw), np.sin(piece.yaw)
    mesh = piece.caster.mesh
    x, y, z = mesh.vertices_xyz.T
    points = np.column_stack([cosine * x - sine * y, sine * x + cosine * y, z])
    placed = TriangleMesh(points + np.append(piece.middle_xy, 0.0), mesh.faces)
    origin = np.array([3.0, -2.0, 1.2])
    aims = np.append(piece.middle_xy, 0.4) + rng.uniform(-0.6, 0.6, (300, 3))
    rays = (aims - origin).astype(np.float32)
    found = piece.hits(origin, rays)
    expected = ObjectCaster(placed).hits(origin, rays, np.ones(3))
    assert set(np.unique(found.kind)) <= {FURNITURE, NOTHING}
    # Rays along an edge may be decided either way.
    assert ((found.kind == NOTHING) != (expected.kind == NOTHING)).mean() < 0.02
    both = (found.kind != NOTHING) & (expected.kind != NOTHING)
    apart = np.abs(found.depth[both] - expected.depth[both])
    assert np.quantile(apart, 0.97) < 1e-3


def test_neighbours_stand_at_the_object():
    rng = np.random.default_rng(0)
    for _ in range(50):
        piece = Neighbour.drawn(LOW, HIGH, rng)
        away = np.hypot(*(piece.middle_xy - (LOW + HIGH)[:2] / 2))
        own = np.hypot(*np.ptp(piece.caster.corners_xyz, axis=0)[:2])
        assert away < np.hypot(*(HIGH - LOW)[:2]) / 2 + own
        assert not piece.is_clear_of(np.append(piece.middle_xy, 0.5))
        assert piece.is_clear_of(np.array([9.0, 9.0, 0.5]))


def test_a_neighbour_hides_what_is_behind_it():
    piece = Neighbour(ObjectCaster(make_furniture("dresser", 0)), np.array([1.0, 0.0]), 0.3)
    origin, rays = np.array([3.0, 0.0, 0.4]), np.array([[-1.0, 0.0, 0.0]], np.float32)
    found = RoomSurroundings(furniture=(piece,)).hits(origin, rays)
    assert found.kind[0] == FURNITURE
    assert 1.2 < found.depth[0] < 2.0


@pytest.mark.parametrize("seed", range(3))
def test_merged_furniture_stays_near_the_object(seed):
    """Merged points lie within the margin around the object's box."""
    plain = dict.fromkeys(
        (name for name in CHANCES if name not in ("single", "furnished", "merged")), 0.0
    )
    caster = ObjectCaster(make_furniture("table", 1))
    low, high = caster.corners_xyz
    more = 0
    for number in range(8):
        apart, merged = (
            ScanAugmentation(
                **plain, registration=0.0, stretch=0.0, resize=0.0, furnished=1.0, merged=merged
            ).scan(caster, np.random.default_rng([seed, number]))
            for merged in (0.0, 1.0)
        )
        assert (merged.points_xyz > low - 0.36).all()
        assert (merged.points_xyz < high + 0.36).all()
        more += len(merged.points_xyz) > len(apart.points_xyz)
    assert more
