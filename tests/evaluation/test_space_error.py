from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.evaluation.space_error import (
    error_against_space,
    path_against_space,
    space_error,
)
from circumspect.geometry import PlanarPose, Trajectory
from circumspect.localization import BRIDGED, LOST, TRACKED, SpaceFix, SpaceTrack

MOUNT = RigidTransform.from_components([0.0, 0.16, 1.2], Rotation.from_euler("x", -2.1))


def poses(count=20):
    turns = np.linspace(0, 2, count)
    return [PlanarPose(1.5 * np.cos(a), 1.5 * np.sin(a), a + np.pi / 2) for a in turns]


def trajectory(places):
    return Trajectory(
        np.arange(len(places)) * 0.1,
        RigidTransform.concatenate([place.as_transform() for place in places]),
    )


def track(places, states=TRACKED, sigma=0.001):
    covariance = np.diag([sigma, sigma, 2 * sigma]) ** 2
    named = [states] * len(places) if isinstance(states, str) else states
    return SpaceTrack.of(
        SpaceFix(0.1 * n, state, place, covariance)
        if state != LOST
        else SpaceFix(0.1 * n, LOST, None, None)
        for n, (place, state) in enumerate(zip(places, named, strict=True))
    )


def test_equal_tracks_have_no_error_and_an_offset_its_length():
    true = poses()
    error = space_error(track(true), trajectory(true))
    assert error.position_max_m == pytest.approx(0, abs=1e-12)
    assert error.nees == pytest.approx(0, abs=1e-9)
    off = [PlanarPose(p.x + 0.003, p.y - 0.004, p.yaw + 0.002) for p in true]
    error = space_error(track(off), trajectory(true))
    assert error.position_rmse_m == pytest.approx(0.005)
    assert error.yaw_max_deg == pytest.approx(np.degrees(0.002))
    assert error.nees == pytest.approx(9 + 16 + 1)
    assert set(error.to_dict()) >= {"position_p95_m", "yaw_p95_deg", "fixes"}


def test_bridged_and_lost_fixes_count_only_where_they_are_asked_for():
    true = poses(6)
    states = [TRACKED, TRACKED, BRIDGED, LOST, BRIDGED, TRACKED]
    assert space_error(track(true, states), trajectory(true)).fixes == 3
    assert space_error(track(true, states), trajectory(true), bridged=True).fixes == 5
    with pytest.raises(InputError, match="no fix"):
        space_error(track(true, LOST), trajectory(true))


def test_a_run_in_a_frame_of_its_own_is_compared_after_alignment():
    true = poses()
    own = RigidTransform.from_components([3.0, -1.0, 0.2], Rotation.from_euler("z", 1.1))
    cameras = trajectory(true)
    run = Trajectory(cameras.stamps, own * cameras.T_map_camera * MOUNT)
    assert error_against_space(run, track(true), MOUNT).rmse_m == pytest.approx(0, abs=1e-9)
    moved = path_against_space(run, track(true), MOUNT)
    np.testing.assert_allclose(moved.positions_xyz, cameras.positions_xyz, atol=1e-9)
    assert path_against_space(run, track(true, LOST), MOUNT) is None
    later = Trajectory(run.stamps + 100, run.T_map_camera)
    assert path_against_space(later, track(true), MOUNT) is None
    with pytest.raises(InputError, match="never saw"):
        error_against_space(run, track(true, LOST), MOUNT)
