import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets import Augmentation
from circumspect.datasets.augmentation import PartialView
from circumspect.geometry import short_edge_triangles

angles = st.floats(0, 2 * np.pi)
arcs = st.floats(np.pi / 2, 2 * np.pi)


def box(count=8000, half=(0.5, 0.4, 0.3), seed=0):
    """Points on the six faces of a box, and which face each is on."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (count, 3))
    axis, side = rng.integers(3, size=count), rng.choice([-1.0, 1.0], count)
    points[np.arange(count), axis] = side
    return points * half, axis, side


@given(angles, st.floats(0.15, 0.7))
def test_one_view_sees_only_the_faces_turned_to_it(heading, elevation):
    points, axis, side = box()
    visible = PartialView(heading, 0.0, elevation, looks=1).sees(points)
    level = np.cos(elevation)
    towards = [level * np.cos(heading), level * np.sin(heading), np.sin(elevation)]
    for face in range(3):
        for sign in (-1.0, 1.0):
            on_face = (axis == face) & (side == sign)
            facing = sign * towards[face]
            if facing > 0.6:
                assert visible[on_face].mean() > 0.9
            elif facing > 0.5:  # grazing, a face hides itself within the tolerance
                assert visible[on_face].mean() > 0.75
            elif facing < 0.0:
                assert visible[on_face].mean() < 0.15  # the rim, thinner than the tolerance


@given(angles, arcs, st.floats(0.15, 0.7))
def test_a_longer_arc_sees_all_that_a_shorter_one_saw(start, arc, elevation):
    points, _, _ = box(3000)
    short = PartialView(start, arc / 2, elevation, looks=3)
    long = PartialView(start, arc, elevation, looks=5)
    if arc < 2 * np.pi:
        assert not (short.sees(points) & ~long.sees(points)).any()


def test_a_full_orbit_shows_the_sides_but_neither_underside_nor_inside():
    points, axis, side = box()
    inside = np.random.default_rng(1).uniform(-0.15, 0.15, (500, 3))
    visible = PartialView(0.3, 2 * np.pi, 0.5, looks=8).sees(np.concatenate([points, inside]))
    underside = (axis == 2) & (side < 0)
    assert visible[: len(points)][~underside].mean() > 0.97
    assert visible[: len(points)][underside].mean() < 0.3  # its rim
    assert not visible[len(points) :].any()


@given(angles, arcs, st.floats(0.15, 0.7), st.floats(-np.pi, np.pi))
def test_turning_object_and_camera_together_changes_nothing(start, arc, elevation, yaw):
    points, _, _ = box(1500)
    turn = np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    still = PartialView(start, arc, elevation).sees(points)
    turned = PartialView(start + yaw, arc, elevation).sees(points @ turn)
    assert (still != turned).mean() < 0.03  # rounding at the borders of pixels


def test_a_single_point_is_seen():
    assert PartialView(0.0, 1.0, 0.4).sees(np.zeros((1, 3))).all()


def test_a_draw_repeats_with_its_seed():
    a, b = (PartialView.drawn(np.random.default_rng(5)) for _ in range(2))
    assert a == b


@pytest.mark.parametrize("seed", range(5))
def test_partial_variants_are_normalised_and_smaller_than_whole_ones(seed):
    points = box(1024)[0].astype(np.float32)
    mesh = short_edge_triangles(points)
    faces = mesh.faces[mesh.chosen_by_area(8000)]
    partial = Augmentation(partial=1.0, holes=0.0, thin=1.0, shift=0.0, scale=(1.0, 1.0))
    whole = Augmentation(partial=0.0, holes=0.0, thin=1.0, shift=0.0, scale=(1.0, 1.0))
    visible = partial.apply(points, faces, np.random.default_rng(seed))
    every = whole.apply(points, faces, np.random.default_rng(seed))
    assert 100 < len(visible) < len(every)
    extent = max(np.hypot(visible[:, 0], visible[:, 1]).max(), np.abs(visible[:, 2]).max())
    assert extent == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(visible.mean(axis=0), 0.0, atol=1e-4)
