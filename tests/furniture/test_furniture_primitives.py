"""Laws of the solids that furniture is built of: they are closed, face outwards, have their size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.furniture.outlines import (
    egg,
    ellipse,
    rectangle,
    refined,
    regular,
    resampled,
    rounded_polygon,
    rounded_rectangle,
    superellipse,
)
from circumspect.furniture.placement import around, both_sides, joined, mirrored, moved, turned
from circumspect.furniture.primitives import (
    box,
    cylinder,
    leg,
    pillow,
    revolved,
    rounded_box,
    slab,
    strip,
    tube,
)
from circumspect.furniture.sheets import evenly_spaced, sheet, shell, smooth_path

sizes = st.floats(0.05, 3.0)


def volume(mesh):
    """Signed volume by the divergence theorem: positive where faces turn outwards."""
    a, b, c = np.moveaxis(mesh.corners_xyz, 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


def shoelace(outline):
    x, y = outline.T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def is_closed(mesh):
    """Each edge is walked as often forwards as backwards, after merging equal vertices."""
    _, merged = np.unique(mesh.vertices_xyz.round(9), axis=0, return_inverse=True)
    faces = merged.reshape(-1)[mesh.faces]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    forward = np.unique(edges, axis=0, return_counts=True)
    backward = np.unique(edges[:, ::-1], axis=0, return_counts=True)
    return all(np.array_equal(f, b) for f, b in zip(forward, backward, strict=True))


ARC = np.stack([np.cos(np.linspace(0, 2, 9)), np.sin(np.linspace(0, 2, 9)), np.zeros(9)], axis=1)
SOLIDS = {
    "box": box((0.4, 0.6, 0.8)),
    "cylinder": cylinder(0.5, 0.3),
    "rounded box": rounded_box((0.6, 0.5, 0.2)),
    "slab": slab(ellipse(1.0, 0.6), 0.05, (0.0, 0.0, 0.7), 0.01),
    "pillow": pillow((0.6, 0.4, 0.15)),
    "leg": leg((0.1, 0.0, 0.0), (0.0, 0.0, 0.4), 0.02, 0.05),
    "round leg": leg((0.0, 0.1, 0.0), (0.0, 0.0, 0.4), 0.02, 0.05, sides=12),
    "revolved": revolved([(0.2, 0.0), (0.1, 0.3), (0.3, 0.5)]),
    "tube": tube(ARC, 0.1),
    "square tube": tube(ARC, np.linspace(0.1, 0.2, 9), sides=4),
    "strip y": strip([-1, 0, 1], 0.0, [0.5, 0.8, 0.5], 0.0, 0.1, "y"),
    "strip x": strip([-1, 0, 1], [0.0, 0.2, 0.0], 1.0, 0.0, 0.1, "x"),
    "strip z": strip([-1, 0, 1], -0.2, 0.2, 0.0, 0.1, "z"),
    "sheet": sheet(np.stack([ARC, np.add(ARC, (0.0, 0.0, 1.0))]), 0.05),
    "shell": shell(
        [(0, 0), (0.2, 0.0), (0.4, 0.1), (0.5, 0.4)], np.full(4, 0.5), np.full(4, 0.1), 0.02
    ),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_closed_and_face_outwards(name):
    assert is_closed(SOLIDS[name])
    assert volume(SOLIDS[name]) > 0


@given(sizes, sizes, sizes)
def test_box_has_its_size_and_volume(width, depth, height):
    mesh = box((width, depth, height), (1.0, 2.0, 3.0))
    np.testing.assert_allclose(np.ptp(mesh.vertices_xyz, axis=0), (width, depth, height))
    assert volume(mesh) == pytest.approx(width * depth * height)
    assert mesh.vertices_xyz[:, 2].min() == 3.0


@given(sizes, sizes, sizes, st.floats(0.001, 0.5))
def test_rounded_box_fills_its_size_and_no_more(width, depth, height, radius):
    mesh = rounded_box((width, depth, height), radius=radius)
    np.testing.assert_allclose(np.ptp(mesh.vertices_xyz, axis=0), (width, depth, height))
    assert 0 < volume(mesh) < width * depth * height


@pytest.mark.parametrize(
    "outline",
    [
        rectangle(2, 1),
        ellipse(2, 1),
        superellipse(2, 1, 4.0),
        rounded_rectangle(2, 1, 0.3),
        rounded_rectangle(2, 1, 9.0),
        regular(4, 1.0),
        egg(1, 2, 0.4),
        rounded_polygon([(1, 0), (0, 1), (-1, 0), (0, -1)], 0.2),
        resampled(rectangle(2, 1), 40),
        refined(rectangle(2, 1), 0.1),
    ],
)
def test_outlines_run_counter_clockwise_without_doubled_corners(outline):
    assert shoelace(outline) > 0
    edges = np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1)
    assert edges.min() > 1e-6


@given(sizes)
def test_regular_square_has_its_width(width):
    np.testing.assert_allclose(np.ptp(regular(4, width), axis=0), width)


def test_refined_keeps_the_outline_and_its_corners():
    cut = refined(rectangle(2, 1), 0.3)
    assert shoelace(cut) == pytest.approx(2.0)
    assert np.linalg.norm(cut - np.roll(cut, 1, axis=0), axis=1).max() <= 0.3


@given(st.floats(-3.2, 3.2), st.sampled_from("xyz"))
def test_turning_keeps_volume_and_turning_back_restores(angle, axis):
    mesh = moved(box((0.4, 0.6, 0.8)), (0.3, 0.2, 0.1))
    there = turned(mesh, angle, axis, (1.0, 2.0, 3.0))
    assert volume(there) == pytest.approx(volume(mesh))
    back = turned(there, -angle, axis, (1.0, 2.0, 3.0))
    np.testing.assert_allclose(back.vertices_xyz, mesh.vertices_xyz, atol=1e-12)


def test_turning_is_counter_clockwise():
    mesh = turned(moved(box((0.1, 0.1, 0.1)), (1.0, 0.0, 0.0)), np.pi / 2)
    np.testing.assert_allclose(mesh.vertices_xyz[:, :2].mean(axis=0), (0.0, 1.0), atol=1e-12)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_mirrors_face_outwards_too(axis):
    mesh = moved(SOLIDS["leg"], (0.5, 0.5, 0.5))
    assert volume(mirrored(mesh, axis)) == pytest.approx(volume(mesh))
    assert volume(both_sides(mesh, axis)) == pytest.approx(2 * volume(mesh))


def test_joined_and_around_add_up():
    one = moved(box((0.1, 0.1, 0.1)), (1.0, 0.0, 0.0))
    assert volume(joined([one, SOLIDS["cylinder"]])) == pytest.approx(
        volume(one) + volume(SOLIDS["cylinder"])
    )
    ring = around(one, 5)
    assert volume(ring) == pytest.approx(5 * volume(one))
    np.testing.assert_allclose(ring.vertices_xyz[:, :2].mean(axis=0), 0.0, atol=1e-12)


def test_tube_keeps_its_width_along_a_bend():
    mesh = tube(ARC, 0.1, 8)
    middle = np.linalg.norm(mesh.vertices_xyz[:-2, :2], axis=1)
    assert np.abs(middle - 1).max() <= 0.1 / 2 / np.cos(np.pi / 8) + 1e-3


def test_smooth_path_keeps_ends_and_cuts_corners():
    path = smooth_path([(0, 0, 0), (1, 0, 0), (1, 1, 0)], 0.2)
    np.testing.assert_array_equal(path[[0, -1]], [(0, 0, 0), (1, 1, 0)])
    assert np.linalg.norm(path - (1, 0, 0), axis=1).min() > 0.05


def test_evenly_spaced_points_are_evenly_spaced():
    steps = np.linalg.norm(np.diff(evenly_spaced([(0, 0), (1, 0), (4, 0)], 9), axis=0), axis=1)
    np.testing.assert_allclose(steps, 0.5)
