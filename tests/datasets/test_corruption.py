"""Corruptions of clouds have the requested kind and severity."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets.corruption import CORRUPTIONS, SEVERITIES, corrupted
from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud

CHAIR = make_furniture("chair", 1).sampled(1000, 0)
CENTRE = CHAIR.points_xyz.mean(axis=0)
RADIUS = np.linalg.norm(CHAIR.points_xyz - CENTRE, axis=1).max()


def after(kind, severity, seed=0, cloud=CHAIR):
    return corrupted(cloud, kind, severity, np.random.default_rng(seed))


def nearest(points, others):
    return np.linalg.norm(points[:, None] - others[None], axis=2).min(axis=1) / RADIUS


@given(st.sampled_from(list(CORRUPTIONS)), st.sampled_from(SEVERITIES), st.integers(0, 2**20))
def test_the_same_seed_gives_the_same_cloud_in_any_unit(kind, severity, seed):
    one, again = after(kind, severity, seed), after(kind, severity, seed)
    np.testing.assert_array_equal(one.points_xyz, again.points_xyz)
    other = after(kind, severity, seed, PointCloud(CHAIR.points_xyz * 250 + 9))
    np.testing.assert_allclose(other.points_xyz, one.points_xyz * 250 + 9, atol=1e-6)
    assert len(one) > 3


@pytest.mark.parametrize("kind", CORRUPTIONS)
def test_corruption_grows_with_severity(kind):
    """By what each does: points moved, missing or added, or the centre displaced."""

    def harm(severity):
        total = 0.0
        for seed in range(6):
            cloud = after(kind, severity, seed)
            moved = nearest(cloud.points_xyz, CHAIR.points_xyz).mean()
            lost = nearest(CHAIR.points_xyz, cloud.points_xyz).mean()
            shifted = np.linalg.norm(cloud.weights @ cloud.points_xyz - CENTRE) / RADIUS
            changed = abs(len(cloud) / len(CHAIR) - 1)
            total += moved + lost + changed + (shifted if kind == "shift" else 0)
        return total

    assert harm(1) > 0
    assert harm(5) > 1.15 * harm(1)


@pytest.mark.parametrize(
    ("kind", "shares"),
    [
        ("drop-global", (0.75, 0.625, 0.5, 0.375, 0.25)),
        ("drop-local", (0.9, 0.8, 0.7, 0.6, 0.5)),
        ("add-global", (1.01, 1.02, 1.03, 1.04, 1.05)),
        ("add-local", (1.1, 1.2, 1.3, 1.4, 1.5)),
        ("occlusion", (0.9, 0.8, 0.7, 0.6, 0.5)),
    ],
)
def test_as_many_points_are_left_as_defined(kind, shares):
    assert [len(after(kind, s)) / len(CHAIR) for s in SEVERITIES] == pytest.approx(shares, abs=2e-3)


def test_an_arc_is_missing_about_the_axis():
    cloud = after("arc", 5)
    azimuth = np.sort(np.arctan2(*(cloud.points_xyz - CENTRE)[:, 1::-1].T))
    gaps = np.diff(np.append(azimuth, azimuth[0] + 2 * np.pi))
    assert np.rad2deg(gaps.max()) >= 180


def test_a_tilt_leans_the_axis():
    for severity in SEVERITIES:
        cloud = after("tilt", severity)
        turn = np.linalg.lstsq(CHAIR.points_xyz - CENTRE, cloud.points_xyz - CENTRE, rcond=None)[0]
        assert np.rad2deg(np.arccos(turn[2, 2])) == pytest.approx(2 * severity, abs=1e-6)


def test_a_shifted_centre_lies_beside_while_the_points_stay():
    for severity in (1, 3):
        cloud = after("shift", severity)
        np.testing.assert_allclose(cloud.points_xyz, CHAIR.points_xyz, atol=1e-12)
        beside = np.linalg.norm((cloud.weights @ cloud.points_xyz - CENTRE)[:2]) / RADIUS
        assert beside == pytest.approx(0.03 * severity, rel=0.25)


def test_a_floor_lies_under_the_object():
    cloud = after("floor", 3)
    floor = cloud.points_xyz[len(CHAIR) :]
    assert np.ptp(floor[:, 2]) < 1e-9
    assert floor[0, 2] == pytest.approx(CHAIR.points_xyz[:, 2].min())


def test_unknown_kinds_and_severities_are_refused():
    with pytest.raises(InputError, match="jitter"):
        after("rain", 1)
    with pytest.raises(InputError, match="1 to 5"):
        after("jitter", 6)
