"""Which keyframes are registered to each other, and the factors that follow."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform
from tracking_world import drive, true_camera

from circumspect.geometry import se3
from circumspect.pose_graph import BetweenFactor, Keyframe
from circumspect.pose_graph.loop_closure import covisible, registered, with_further_noise
from circumspect.registration import (
    CompactSurface,
    FreeSpace,
    RegistrationSettings,
    Scan,
    ScanSurface,
)

I6 = np.eye(6)


def keyframe(number: int, angle: float, off: float = 0.0) -> Keyframe:
    """Taken at an angle [rad] of the drive, estimated `off` [m] from there."""
    frame = drive(np.array([angle]))[0]
    T = true_camera(angle) * RigidTransform.from_translation([off, 0.0, 0.0])
    surface = ScanSurface.from_scan(Scan.from_frame(frame))
    surface = surface.with_vertical_floor_normals(true_camera(angle))
    compact, free_space = CompactSurface.from_surface(surface), FreeSpace.from_frame(frame)
    return Keyframe(number, T.as_matrix(), 1e-6 * I6, compact, free_space, 1.5)


def measured(one: Keyframe, other: Keyframe) -> BetweenFactor | None:
    return registered(one, other, 0.03, RegistrationSettings())


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_further_noise_takes_information_away(seed: int, rank: int) -> None:
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(6, rank)) * 100
    information, further = A @ A.T, np.diag(rng.uniform(1.0, 1e4, 6))
    left = with_further_noise(information, further)
    scale = 1e-6 * np.abs(information).max() + 1e-2
    for less, more in ((left, information), (left, further), (np.zeros((6, 6)), left)):
        assert np.linalg.eigvalsh(more - less).min() > -scale


def test_little_further_noise_leaves_the_information() -> None:
    information = np.diag([1e6, 1e6, 1e6, 1e5, 1e5, 1e5])
    np.testing.assert_allclose(with_further_noise(information, 1e9 * I6), information, rtol=1e-2)


def test_keyframes_that_show_the_other_side_are_left_out() -> None:
    others = [keyframe(number, np.radians(angle)) for number, angle in enumerate((45, 135, 225))]
    poses = np.stack([other.T_map_camera for other in others])
    for angle, number in ((50, 0), (225, 2)):
        found = covisible(keyframe(30, np.radians(angle)), others, poses)
        assert [other.number for other in found] == [number]


def test_a_loop_is_measured_whatever_the_drift() -> None:
    first, second = np.radians(45.0), np.radians(48.0)
    factor = measured(keyframe(0, first), keyframe(30, second, off=0.03))
    assert factor is not None
    assert factor.robust
    true = true_camera(first).inv() * true_camera(second)
    assert np.linalg.norm((true.inv() * factor.T_first_second).translation) < 0.01


def test_views_from_different_sides_inform_less() -> None:
    one = keyframe(0, np.radians(45.0))
    near, far = (measured(one, keyframe(30, np.radians(angle))) for angle in (47.0, 65.0))
    assert near is not None
    assert far is not None
    assert np.trace(far.information) < np.trace(near.information)


def test_views_from_opposite_sides_are_linked_by_the_floor_alone() -> None:
    """It constrains roll, pitch and height, but neither heading nor position."""
    factor = measured(keyframe(0, np.radians(45.0)), keyframe(30, np.radians(225.0), off=0.1))
    assert factor is not None
    assert np.linalg.matrix_rank(factor.information, tol=1e-3, hermitian=True) == 3
    true = true_camera(np.radians(45.0)).inv() * true_camera(np.radians(225.0))
    error = se3.log(true.inv() * factor.T_first_second)
    assert error @ factor.information @ error < 1


def test_a_keyframe_sees_through_free_space_only() -> None:
    key = keyframe(0, np.radians(45.0))
    T = RigidTransform.from_matrix(key.T_map_camera)
    assert key.sees_through(T.apply(np.array([[0.0, 0.0, 0.7]])))[0]
    assert not key.sees_through(T.apply(np.array([[0.0, 0.0, -0.7]])))[0]
    assert key.sees_through(T.apply(key.surface.scan.points_xyz)).mean() < 0.02
