"""A few points far away do not set the scale of an object."""

from __future__ import annotations

import numpy as np
import pytest

from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PointCloud, without_stray_points


def chair(count: int = 6000) -> np.ndarray:
    return make_furniture("chair", 1).sampled(count, 0).points_xyz


@pytest.mark.parametrize("count", [1, 5, 30])
@pytest.mark.parametrize("away", [2.0, 1e3, 1e9])
def test_stray_points_are_removed_and_counted(
    count: int, away: float, caplog: pytest.LogCaptureFixture
):
    points = chair()
    directions = np.random.default_rng(0).normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    both = np.concatenate(
        [directions[: count // 2] * away, points, directions[count // 2 :] * away]
    )
    found = without_stray_points(PointCloud(both))
    np.testing.assert_array_equal(found.points_xyz, points)
    assert f"ignored {count} of {6000 + count} points far from all others" in caplog.text


def test_a_small_group_is_a_stray_as_well():
    points = chair()
    group = np.random.default_rng(0).normal(3.0, 0.02, (20, 3))
    assert len(without_stray_points(PointCloud(np.concatenate([points, group])))) == 6000


@pytest.mark.parametrize("category", CATEGORIES)
def test_objects_have_no_strays(category: str):
    for variant in range(3):
        cloud = make_furniture(category, variant).sampled(5000, variant)
        assert without_stray_points(cloud) is cloud


def test_a_thin_part_is_no_stray():
    """A pole of few points on a foot."""
    foot = np.random.default_rng(0).random((20_000, 3)) * [0.4, 0.4, 0.05]
    pole = np.column_stack([np.full(150, 0.2), np.full(150, 0.2), np.linspace(0.05, 1.8, 150)])
    cloud = PointCloud(np.concatenate([foot, pole]))
    assert without_stray_points(cloud) is cloud


def test_two_objects_are_no_strays():
    points = chair(3000)
    cloud = PointCloud(np.concatenate([points, points[::20] + np.array([9, 0, 0])]))
    assert without_stray_points(cloud) is cloud


@pytest.mark.parametrize("points", [np.zeros((500, 3)), np.eye(3), np.ones((1, 3)) * 7])
def test_degenerate_clouds_are_returned_as_they_are(points: np.ndarray):
    cloud = PointCloud(points)
    assert without_stray_points(cloud) is cloud
