from __future__ import annotations

import numpy as np
import pytest
from ceiling_world import MOUNT, camera, corners, unlike
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PlanarPose
from circumspect.localization import FixedCamera, TagMount, fused, tag_pose

POSES = st.builds(PlanarPose, st.floats(-1.0, 1.0), st.floats(-0.8, 0.8), st.floats(-3.2, 3.2))


@given(POSES, st.floats(-8, 8), st.floats(-180, 180))
def test_a_projected_pose_is_recovered(pose, tilt, heading):
    one = camera(0.1, -0.2, tilt=(tilt, -tilt / 2), heading=heading)
    found = tag_pose(one, MOUNT, corners(one, pose))
    np.testing.assert_allclose(unlike(found.T_map_base, pose), 0, atol=1e-9)
    assert found.squared_residual < 1e-9
    assert np.linalg.eigvalsh(found.noise).min() > 0


@given(st.floats(-3.1, 3.1))
def test_the_orientation_of_the_tag_on_the_robot_does_not_change_the_pose(turn):
    """The pose is that of the base, wherever the tag is mounted."""
    one, pose = camera(), PlanarPose(0.3, 0.2, 0.5)
    mount = TagMount(3, 0.2, 0.3, PlanarPose(-0.03, 0.06, turn))
    found = tag_pose(one, mount, corners(one, pose, mount))
    np.testing.assert_allclose(unlike(found.T_map_base, pose), 0, atol=1e-9)


def test_stated_noise_is_that_of_the_corners():
    """Normalised squared errors have the mean of their three degrees of freedom."""
    rng, one, sigma = np.random.default_rng(0), camera(), 0.06
    squares = []
    for _ in range(400):
        pose = PlanarPose(*rng.uniform(-0.9, 0.9, 2), rng.uniform(-3, 3))
        pixels = corners(one, pose) + rng.normal(0, sigma, (4, 2))
        found = tag_pose(one, MOUNT, pixels, sigma, 0.0)
        # A misfit beyond the expected one enlarges the noise; here it is known.
        noise = found.noise / max(1.0, found.squared_residual / 5)
        error = unlike(found.T_map_base, pose)
        squares.append(error @ np.linalg.solve(noise, error))
    # Standard deviation of the mean: sqrt(2 * 3 / 400) = 0.12.
    assert np.mean(squares) == pytest.approx(3, abs=0.5)


def test_stated_bias_is_that_of_the_cameras_place_and_lens():
    rng, pose = np.random.default_rng(1), PlanarPose(0.5, 0.4, 1.0)
    sigmas = np.array([1e-3, 1e-3, 5e-4, 2e-3, 2e-3, 1e-3])
    one = camera(covariance=np.diag(sigmas**2))
    found = tag_pose(one, MOUNT, corners(one, pose), 0.06, 0.1)
    squares = []
    for _ in range(400):
        off = RigidTransform.from_exp_coords(rng.normal(0, sigmas))
        true = FixedCamera("true", one.lens, one.T_map_camera * off)
        pixels = corners(true, pose) + rng.normal(0, 0.1, 2)
        error = unlike(tag_pose(one, MOUNT, pixels).T_map_base, pose)
        squares.append(error @ np.linalg.solve(found.bias, error))
    assert np.mean(squares) == pytest.approx(3, abs=0.5)


def test_two_cameras_fused_equal_one_fit_to_both():
    rng, pose = np.random.default_rng(2), PlanarPose(0.2, 0.1, 0.7)
    pair = camera(-0.8, 0.0), camera(0.9, 0.3, heading=-70.0)
    pixels = [corners(one, pose) + rng.normal(0, 0.05, (4, 2)) for one in pair]
    single = [tag_pose(one, MOUNT, uv, 0.05, 0.0) for one, uv in zip(pair, pixels, strict=True)]

    from scipy.optimize import least_squares

    def residuals(values):
        place = PlanarPose(*values)
        return np.concatenate(
            [(corners(one, place) - uv).ravel() for one, uv in zip(pair, pixels, strict=True)]
        )

    joint = least_squares(residuals, [pose.x, pose.y, pose.yaw], x_scale=[1e-3, 1e-3, 1e-2])
    # Both fits are of the same sigma; what a bad fit adds to the noise is taken out.
    even = [
        type(p)(p.T_map_base, p.noise / max(1, p.squared_residual / 5), p.bias, p.squared_residual)
        for p in single
    ]
    np.testing.assert_allclose(unlike(fused(even).T_map_base, PlanarPose(*joint.x)), 0, atol=5e-6)


def test_badly_fitting_corners_get_a_larger_covariance():
    one, pose = camera(), PlanarPose()
    good, bad = corners(one, pose), corners(one, pose)
    bad[0] += 2.0
    assert tag_pose(one, MOUNT, bad).noise[0, 0] > 4 * tag_pose(one, MOUNT, good).noise[0, 0]
    assert tag_pose(one, MOUNT, bad).squared_residual > 40


def test_corners_that_are_no_tag_on_the_plane_are_refused():
    one = camera()
    with pytest.raises(GeometryError, match="plane"):
        tag_pose(one, TagMount(3, 0.2, 4.0), corners(one, PlanarPose()))
    with pytest.raises(GeometryError, match="no square"):
        tag_pose(one, MOUNT, np.full((4, 2), 500.0))


@pytest.mark.parametrize("what", [{"tag_id": 587}, {"tag_id": -1}, {"size": 0}, {"height": np.nan}])
def test_impossible_mounts_are_refused(what):
    with pytest.raises(InputError):
        TagMount(**what)
