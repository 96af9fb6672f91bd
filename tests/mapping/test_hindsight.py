from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform
from tracking_world import SHORT, blind, follow, place_errors, short_drive, true_camera

from circumspect.geometry import PlanarPose, se3
from circumspect.mapping import RegisteredPoses, TrackingSettings, hindsight
from circumspect.mapping.hindsight import Hindsight
from circumspect.mapping.motion import Belief

SOME = np.array([0.3, 0.2, 0.5, 0.2, 0.1, 0.4])


def covariance(rng: np.random.Generator, size: float) -> np.ndarray:
    root = rng.normal(size=(6, 8)) * size
    return root @ root.T


def random_stretch(
    seed: int, count: int
) -> tuple[list[Belief], list[np.ndarray], list[np.ndarray]]:
    """Predictions one from the other, and of each step its derivative and covariance."""
    rng = np.random.default_rng(seed)
    beliefs, F, Q = [Belief(se3.exp(rng.normal(size=6)), covariance(rng, 0.01))], [], []
    for _ in range(count):
        motion = se3.exp(0.3 * rng.normal(size=6) * SOME)
        F.append(se3.adjoint(motion.inv()))
        Q.append(covariance(rng, 0.01))
        beliefs.append(beliefs[-1].moved(motion, Q[-1]))
    return beliefs, F, Q


@given(st.integers(0, 10**6), st.integers(1, 12))
def test_it_is_what_all_poses_together_are_likeliest_to_be(seed: int, count: int) -> None:
    """Slowly: the mean of every pose given the last one, of their joint normal distribution."""
    beliefs, F, Q = random_stretch(seed, count)
    joint = np.zeros((count + 1, 6, 6))  # of each pose with the last
    marginal = [beliefs[0].covariance]
    for f, q in zip(F, Q, strict=True):
        marginal.append(f @ marginal[-1] @ f.T + q)
    for k in range(count + 1):
        joint[k] = marginal[k]
        for f in F[k:]:
            joint[k] = joint[k] @ f.T
    change = 1e-4 * np.random.default_rng(seed).normal(size=6)
    likeliest = joint @ np.linalg.solve(marginal[-1], change)

    later = Hindsight()
    numbers = [later.hear(b, e, e, False) for b, e in zip([beliefs[0], *beliefs], beliefs[:-1],
                                                          strict=False)]  # fmt: skip
    last = beliefs[-1]
    found = Belief(last.T_map_camera * se3.exp(change), 1e-3 * last.covariance)
    assert later.hear(beliefs[-2], last, found, True) is None
    for number, belief, expected in zip(numbers, beliefs, likeliest, strict=False):
        assert number is not None
        seen = later.seen(belief.T_map_camera, number)
        moved = se3.log(belief.T_map_camera.inv() * seen)
        np.testing.assert_allclose(moved, expected, atol=1e-6)


def test_until_a_pose_is_certain_again_nothing_is_learnt() -> None:
    beliefs, _, _ = random_stretch(0, 4)
    later = Hindsight()
    assert later.hear(beliefs[0], beliefs[0], beliefs[0], True) is None
    for before, expected in pairwise(beliefs):
        off = Belief(expected.T_map_camera * se3.exp(0.01 * SOME), expected.covariance)
        number = later.hear(before, expected, off, False)
        assert number is not None
        seen = later.seen(off.T_map_camera, number)
        np.testing.assert_allclose(seen.as_matrix(), off.T_map_camera.as_matrix(), atol=1e-12)


def test_of_a_very_long_stretch_the_first_poses_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hindsight, "MOST", 3)
    beliefs, _, _ = random_stretch(1, 200)
    later = Hindsight()
    numbers = [later.hear(b, e, e, False) for b, e in pairwise(beliefs[:-1])]
    off = Belief(beliefs[-1].T_map_camera * se3.exp(0.01 * SOME), beliefs[-1].covariance)
    later.hear(beliefs[-2], beliefs[-1], off, True)
    origin = RigidTransform.identity()
    moved = [np.abs(se3.log(later.seen(origin, number))).max() > 0 for number in numbers]
    assert moved == [False] * (len(numbers) - 3) + [True] * 3


def turned_while_blind(blind_from: int, end: int) -> list:
    """The wheels tell of turns that are not, while the camera sees nothing."""
    frames = []
    for number, frame in enumerate(short_drive()):
        wrong = np.radians(1.5) * np.clip(number - blind_from + 1, 0, end - blind_from)
        told = frame.odometry.T_odom_base @ PlanarPose(0.0, 0.0, wrong)
        seen = blind(frame) if blind_from <= number < end else frame
        frames.append(replace(seen, odometry=replace(frame.odometry, T_odom_base=told)))
    return frames


def turn_errors_deg(estimates: list) -> np.ndarray:
    first = estimates[0].T_map_camera * true_camera(float(SHORT[0])).inv()
    true = [first * true_camera(float(angle)) for angle in SHORT]
    pairs = zip(estimates, true, strict=True)
    return np.degrees([(e.T_map_camera.inv() * T).rotation.magnitude() for e, T in pairs])


def test_where_the_wheels_led_a_blind_camera_is_told_better_afterwards() -> None:
    poses = RegisteredPoses(settings=TrackingSettings(certain=(np.radians(0.5), 0.012)))
    told = follow(turned_while_blind(5, 11), poses)
    dark = np.array([not estimate.certain for estimate in told])
    assert dark[6:11].all()
    assert not dark[[0, 1, 2, 3, 4, -1]].any()
    final = [e.at(T) for e, T in zip(told, poses.corrected(told), strict=True)]
    before, after = turn_errors_deg(told)[5:11], turn_errors_deg(final)[5:11]
    assert before.max() > 5
    assert np.sqrt((after**2).mean()) < np.sqrt((before**2).mean()) / 3
    assert place_errors(final, SHORT).max() < place_errors(told, SHORT).max() + 0.001
    for one, other, sure in zip(told, final, ~dark, strict=True):
        if sure:
            same = one.T_map_camera.as_matrix()
            np.testing.assert_allclose(same, other.T_map_camera.as_matrix(), atol=1e-9)
