"""What networks are shown of a cloud."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification import GridSpec, PointsSpec, input_spec_from_dict
from circumspect.classification.input_spec import MAX_MARGIN
from circumspect.errors import GeometryError, InputError
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud
from circumspect.geometry.farthest_points import farthest_points
from circumspect.grid import CylindricalGrid


def chair(points=3000):
    return make_furniture("chair", 1).sampled(points, 0)


@given(
    st.integers(1, 4), st.integers(1, 5000), st.booleans(), st.floats(1, MAX_MARGIN), st.booleans()
)
def test_points_specs_round_trip_through_json(views, count, surface, margin, farthest_first):
    input_spec = PointsSpec(count, surface, views, margin=margin, farthest_first=farthest_first)
    assert input_spec_from_dict(json.loads(json.dumps(input_spec.to_dict()))) == input_spec
    assert input_spec.with_views(7).azimuth_views == 7


def test_a_rectangular_grid_has_one_view():
    input_spec = GridSpec("rectangular")
    assert input_spec.with_views(1) == input_spec
    with pytest.raises(InputError, match="leave out --azimuth-views"):
        input_spec.with_views(4)
    assert GridSpec().with_views(4).azimuth_views == 4


@pytest.mark.parametrize(
    "document",
    [
        {"kind": "points", "shape": 3},
        {"kind": "points", "count": 0},
        {"kind": "points", "margin": 0.99},
        {"kind": "points", "farthest_first": 1},
        {"kind": "points", "count": 20_000, "farthest_first": True},
        {"farthest_first": True},
        {"margin": 4.01},
        {"margin": float("nan")},
        {"margin": "1.1"},
        {"margin": True},
    ],
)
def test_invalid_settings_are_refused(document):
    with pytest.raises(InputError):
        input_spec_from_dict(document)


@given(yaw=st.floats(-7, 7), count=st.integers(10, 400), scale=st.floats(1e-3, 1e3))
def test_points_turn_with_the_object_at_any_place_and_unit(yaw, count, scale):
    input_spec, cloud = PointsSpec(count), chair()
    moved = PointCloud(cloud.points_xyz * scale + [3 * scale, -scale, 2 * scale])
    still, turned = input_spec.inputs(moved, [0.0, yaw])[:, 0]
    np.testing.assert_allclose(
        still, input_spec.inputs(PointCloud(cloud.points_xyz))[0, 0], atol=1e-5
    )
    angle = np.arctan2(turned[:, 1], turned[:, 0]) - np.arctan2(still[:, 1], still[:, 0])
    away = np.hypot(still[:, 0], still[:, 1])
    np.testing.assert_allclose(away, np.hypot(turned[:, 0], turned[:, 1]), atol=1e-5)
    wrong = np.abs((angle - yaw + np.pi) % (2 * np.pi) - np.pi) * away
    assert wrong.max() < 1e-4


def test_points_lie_within_the_cylinder_and_reach_its_wall():
    points = PointsSpec(3000).inputs(chair())[0, 0]
    reach = max(np.hypot(points[:, 0], points[:, 1]).max(), np.abs(points[:, 2]).max())
    assert reach == pytest.approx(1.0, abs=1e-5)


@given(st.sampled_from(["cylindrical", "rectangular"]), st.floats(1, MAX_MARGIN))
def test_a_grid_with_a_margin_is_that_of_a_larger_object(kind, margin):
    cloud = chair(500)
    tight, wide = (GridSpec(kind, margin=m).bounds(cloud) for m in (1.0, margin))
    assert wide.centre_xyz == tight.centre_xyz
    lengths = [[v for v in vars(b).values() if isinstance(v, float) and v] for b in (tight, wide)]
    np.testing.assert_allclose(lengths[1], np.multiply(margin, lengths[0]))


@given(st.floats(1, MAX_MARGIN))
def test_points_with_a_margin_are_those_without_drawn_together(margin):
    cloud = chair(500)
    tight, wide = (PointsSpec(400, margin=m).inputs(cloud) for m in (1.0, margin))
    np.testing.assert_allclose(margin * wide, tight, rtol=1e-5, atol=1e-6)


def test_stored_specs_without_a_margin_have_none():
    for input_spec in (GridSpec(), PointsSpec()):
        document = input_spec.to_dict()
        del document["margin"]
        document.pop("farthest_first", None)
        assert input_spec_from_dict(document) == input_spec


@pytest.mark.parametrize("surface", [False, True])
def test_a_small_cloud_gives_as_many_points_as_a_large_one(surface):
    cloud = chair(300)
    points = PointsSpec(1000, surface).inputs(cloud)[0, 0]
    assert points.shape == (1000, 3)
    distinct = len(np.unique(points, axis=0))
    assert distinct == (1000 if surface else 300)


@given(yaw=st.floats(-7, 7), count=st.integers(2, 60), margin=st.floats(1, MAX_MARGIN))
def test_farthest_first_points_are_the_same_points_in_another_order(yaw, count, margin):
    input_spec, cloud = PointsSpec(count, margin=margin), chair(300)
    plain = input_spec.inputs(cloud, [0.0, yaw])[:, 0]
    ordered = replace(input_spec, farthest_first=True).inputs(cloud, [0.0, yaw])[:, 0]
    for points, given_order in zip(ordered, plain, strict=True):
        np.testing.assert_array_equal(np.sort(points, axis=0), np.sort(given_order, axis=0))
    still = ordered[0].astype(np.float64)
    assert np.linalg.norm(still[0]) == pytest.approx(np.linalg.norm(still, axis=1).max())
    gaps = np.linalg.norm(still[:, None] - still, axis=2)
    for i in range(1, count // 2):
        # Of points that are equally far to the last digit either may come first.
        nearest = gaps[:, :i].min(axis=1)
        assert nearest[i] == pytest.approx(nearest.max(), abs=1e-5)


def test_training_points_come_farthest_first_too():
    samples = chair(400).points_xyz.astype(np.float32)
    input_spec = PointsSpec(100, farthest_first=True)
    points = input_spec.of_samples(samples, np.random.default_rng(3))
    plain = PointsSpec(100).of_samples(samples, np.random.default_rng(3))
    np.testing.assert_array_equal(np.sort(points, axis=0), np.sort(plain, axis=0))
    np.testing.assert_array_equal(farthest_points(points, 50), np.arange(50))


def test_points_can_not_be_derived_from_a_grid():
    with pytest.raises(InputError, match="points, not grids"):
        PointsSpec().accepts(CylindricalGrid().hits(chair().points_xyz))
    with pytest.raises(GeometryError):
        PointsSpec().inputs(PointCloud(np.zeros((5, 3))))


def test_a_rectangular_grid_holds_the_object_at_every_yaw():
    cloud, input_spec = chair(), GridSpec("rectangular")
    bounds = input_spec.bounds(cloud)
    corner = cloud.points_xyz - np.asarray(bounds.centre_xyz)
    assert np.hypot(corner[:, 0], corner[:, 1]).max() <= bounds.half_width * (1 + 1e-9)
    counts = input_spec.grids(cloud, np.linspace(0, 1.5, 7).tolist()).sum(axis=(1, 2, 3, 4))
    assert counts.min() > 0.8 * counts.max()
