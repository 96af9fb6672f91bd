from __future__ import annotations

import copy

import numpy as np
import pytest
from evo.core import metrics, sync
from evo.core.trajectory import PoseTrajectory3D
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import CircumspectError, GeometryError, InputError
from circumspect.evaluation.trajectory_error import (
    Alignment,
    absolute_trajectory_error,
    associated,
    places_and_turns,
    relative_pose_error,
    rigid_alignment,
)
from circumspect.geometry import Trajectory

seeds = st.integers(0, 2**32 - 1)


def wandering(rng: np.random.Generator, count: int = 30) -> Trajectory:
    """A path with all kinds of orientations."""
    steps = np.cumsum(rng.normal(0, 0.2, (count, 3)), axis=0)
    poses = RigidTransform.from_components(steps, Rotation.random(count, rng=rng))
    return Trajectory(100 + np.arange(count) * 0.5, poses)


def disturbed(
    truth: Trajectory, rng: np.random.Generator, metres: float = 0.05, radians: float = 0.05
) -> Trajectory:
    """The same path with noise, in another frame, with other stamps within the tolerance."""
    count = len(truth)
    noise = RigidTransform.from_components(
        rng.normal(0, metres, (count, 3)), Rotation.from_rotvec(rng.normal(0, radians, (count, 3)))
    )
    stamps = truth.stamps + rng.uniform(-0.004, 0.004, count)
    return Trajectory(stamps, some_pose(rng) * truth.T_map_camera * noise)


def some_pose(rng: np.random.Generator) -> RigidTransform:
    return RigidTransform.from_components(rng.normal(0, 3, 3), Rotation.random(rng=rng))


def as_evo(trajectory: Trajectory) -> PoseTrajectory3D:
    return PoseTrajectory3D(
        poses_se3=list(trajectory.T_map_camera.as_matrix()), timestamps=trajectory.stamps.copy()
    )


def evo_statistics(metric: metrics.PE, pair: tuple) -> dict[str, float]:
    metric.process_data(pair)
    return metric.get_all_statistics()


@settings(max_examples=40)
@given(seeds, st.sampled_from([Alignment.RIGID, Alignment.FIRST_POSE]), st.integers(0, 10))
def test_absolute_error_equals_that_of_evo(seed: int, alignment: Alignment, missing: int) -> None:
    rng = np.random.default_rng(seed)
    truth = wandering(rng)
    kept = np.sort(rng.permutation(len(truth))[missing:])
    whole = disturbed(truth, rng)
    estimate = Trajectory(whole.stamps[kept], whole.T_map_camera[kept])

    ours = absolute_trajectory_error(estimate, truth, alignment)
    reference, theirs = sync.associate_trajectories(as_evo(truth), as_evo(estimate))
    theirs = copy.deepcopy(theirs)
    if alignment is Alignment.RIGID:
        theirs.align(reference)
    else:
        theirs.align_origin(reference)
    places = evo_statistics(metrics.APE(metrics.PoseRelation.translation_part), (reference, theirs))
    angles = evo_statistics(
        metrics.APE(metrics.PoseRelation.rotation_angle_deg), (reference, theirs)
    )
    assert ours.poses == len(kept)
    assert (ours.rmse_m, ours.median_m, ours.max_m) == pytest.approx(
        (places["rmse"], places["median"], places["max"]), abs=1e-9
    )
    assert (ours.rotation_rmse_deg, ours.rotation_median_deg) == pytest.approx(
        (angles["rmse"], angles["median"]), abs=1e-9
    )


@settings(max_examples=40)
@given(seeds, st.integers(1, 5))
def test_relative_error_equals_that_of_evo(seed: int, delta: int) -> None:
    rng = np.random.default_rng(seed)
    truth = wandering(rng)
    estimate = disturbed(truth, rng)
    ours = relative_pose_error(estimate, truth, delta)
    pair = sync.associate_trajectories(as_evo(truth), as_evo(estimate))
    one, other = (
        evo_statistics(metrics.RPE(relation, delta, metrics.Unit.frames, all_pairs=True), pair)
        for relation in (
            metrics.PoseRelation.translation_part,
            metrics.PoseRelation.rotation_angle_deg,
        )
    )
    assert (ours.rmse_m, ours.median_m, ours.max_m) == pytest.approx(
        (one["rmse"], one["median"], one["max"]), abs=1e-9
    )
    assert (ours.rotation_rmse_deg, ours.rotation_max_deg) == pytest.approx(
        (other["rmse"], other["max"]), abs=1e-9
    )


@given(seeds)
def test_a_moved_trajectory_has_no_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = wandering(rng)
    moved = truth.moved(some_pose(rng))
    for error in (
        absolute_trajectory_error(moved, truth),
        absolute_trajectory_error(moved, truth, Alignment.ORIENTATIONS),
        absolute_trajectory_error(moved, truth, Alignment.FIRST_POSE),
        relative_pose_error(moved, truth, 3),
    ):
        assert error.max_m < 1e-9
        assert error.rotation_max_deg < 1e-6


@given(seeds)
def test_no_other_alignment_is_better_than_the_rigid_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = wandering(rng)
    estimate = disturbed(truth, rng)
    best = absolute_trajectory_error(estimate, truth).rmse_m
    T = rigid_alignment(estimate.positions_xyz, truth.positions_xyz)
    nudge = RigidTransform.from_exp_coords(rng.normal(0, 0.01, 6))
    other = absolute_trajectory_error(estimate.moved(nudge * T), truth, Alignment.NONE).rmse_m
    assert best <= other + 1e-12
    assert best <= absolute_trajectory_error(estimate, truth, Alignment.FIRST_POSE).rmse_m + 1e-12


@given(st.floats(-170, 170), st.floats(-5, 5))
def test_yaw_is_the_rotation_about_the_vertical(yaw_deg: float, shift: float) -> None:
    truth = wandering(np.random.default_rng(1))
    turned = truth.positions_xyz + np.array([shift, 0, 0])
    spin = Rotation.from_euler("z", yaw_deg, degrees=True)
    estimate = Trajectory(
        truth.stamps,
        RigidTransform.from_components(turned, spin * truth.T_map_camera.rotation),
    )
    error = absolute_trajectory_error(estimate, truth, Alignment.NONE)
    assert error.yaw_rmse_deg == pytest.approx(abs(yaw_deg), abs=1e-6)
    assert error.rotation_max_deg == pytest.approx(abs(yaw_deg), abs=1e-5)
    assert error.rmse_m == pytest.approx(abs(shift), abs=1e-9)


def test_pitch_is_no_yaw() -> None:
    truth = wandering(np.random.default_rng(2))
    nod = Rotation.from_euler("y", 4, degrees=True)
    poses = RigidTransform.from_components(truth.positions_xyz, nod * truth.T_map_camera.rotation)
    error = absolute_trajectory_error(Trajectory(truth.stamps, poses), truth, Alignment.NONE)
    assert error.yaw_max_deg < 1e-9
    assert error.rotation_rmse_deg == pytest.approx(4)


def test_relative_yaw_is_about_the_map_s_vertical() -> None:
    """A camera that looks forward, its optical axes turned from the map's."""
    count = 12
    level = Rotation.from_matrix([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    places = np.column_stack([np.cos(np.arange(count)), np.sin(np.arange(count)), np.ones(count)])
    drift = Rotation.from_rotvec(np.radians(np.outer(np.arange(count), [0, 0, 2.0])))
    truth = Trajectory(
        np.arange(count), RigidTransform.from_components(places, Rotation.concatenate([level] * 12))
    )
    estimate = Trajectory(np.arange(count), RigidTransform.from_components(places, drift * level))
    error = relative_pose_error(estimate, truth)
    assert error.yaw_rmse_deg == pytest.approx(2.0, abs=1e-9)


@given(seeds)
def test_each_stamp_is_used_once_and_within_the_tolerance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = (
        Trajectory(np.unique(rng.uniform(0, 3, n)), RigidTransform.identity(n))
        for n in rng.integers(1, 40, 2)
    )
    a, b = associated(one, other, tolerance=0.05, min_pairs=0)
    assert (np.abs(a.stamps - b.stamps) <= 0.05).all()
    assert set(a.stamps) <= set(one.stamps)
    assert set(b.stamps) <= set(other.stamps)
    backward, forward = associated(other, one, tolerance=0.05, min_pairs=0)
    if len(one) != len(other):
        np.testing.assert_array_equal(forward.stamps, a.stamps)
        np.testing.assert_array_equal(backward.stamps, b.stamps)


def test_without_common_stamps_there_is_no_error() -> None:
    truth = wandering(np.random.default_rng(3))
    later = Trajectory(truth.stamps + 1000, truth.T_map_camera)
    with pytest.raises(InputError, match="0 of 30 estimated and 30 true poses have stamps within"):
        absolute_trajectory_error(later, truth)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_too_few_poses(count: int) -> None:
    truth = wandering(np.random.default_rng(3))
    few = Trajectory(truth.stamps[:count], truth.T_map_camera[:count])
    for estimate, reference in ((few, truth), (truth, few)):
        with pytest.raises(InputError, match=f"^{count} of .*at least 3 are needed$"):
            absolute_trajectory_error(estimate, reference)
        with pytest.raises(InputError, match="at least 4 are needed"):
            relative_pose_error(estimate, reference, delta_frames=3)


@pytest.mark.parametrize("along", [[0.0, 0.0, 0.0], [0.3, -0.1, 0.7]])
def test_a_line_determines_no_rigid_alignment(along: list[float]) -> None:
    places = np.outer(np.arange(5), along)
    poses = RigidTransform.from_components(places, Rotation.identity(5))
    line = Trajectory(np.arange(5), poses)
    with pytest.raises(GeometryError, match="align the first poses instead"):
        absolute_trajectory_error(line, line)
    for alignment in (Alignment.FIRST_POSE, Alignment.ORIENTATIONS):
        assert absolute_trajectory_error(line, line, alignment).max_m < 1e-12


def test_orientations_align_a_short_path_better_than_positions() -> None:
    rng = np.random.default_rng(4)
    truth = wandering(rng)
    short = Trajectory(
        truth.stamps,
        RigidTransform.from_components(0.002 * truth.positions_xyz, truth.T_map_camera.rotation),
    )
    estimate = disturbed(short, rng, metres=0.002, radians=0.002)
    by_places = absolute_trajectory_error(estimate, short, Alignment.RIGID)
    by_turns = absolute_trajectory_error(estimate, short, Alignment.ORIENTATIONS)
    assert by_turns.rotation_rmse_deg < 0.5 < by_places.rotation_rmse_deg


@pytest.mark.parametrize(
    ("arguments", "word"),
    [({"delta_frames": 0}, "delta_frames 0"), ({"tolerance": -1.0}, "0 s or more")],
)
def test_invalid_settings_are_refused(arguments: dict, word: str) -> None:
    truth = wandering(np.random.default_rng(3))
    with pytest.raises(CircumspectError, match=word):
        relative_pose_error(truth, truth, **arguments)


def test_rotations_of_a_short_thin_path_are_compared_directly() -> None:
    """Millimetres of noise on a path of 80 mm turn the fit of its positions by any angle."""
    rng = np.random.default_rng(3)
    places = np.column_stack([np.linspace(0, 0.08, 12), *rng.normal(0, 1e-4, (2, 12))])
    noise = np.column_stack([np.zeros(12), *rng.normal(0, 2e-3, (2, 12))])
    upright = Rotation.identity(12)
    stamps = np.arange(12.0)
    truth = Trajectory(stamps, RigidTransform.from_components(places, upright))
    estimate = Trajectory(stamps, RigidTransform.from_components(places + noise, upright))
    by_places = absolute_trajectory_error(estimate, truth)
    reported = places_and_turns(estimate, truth)
    assert by_places.rotation_rmse_deg > 5
    assert reported.rotation_max_deg < 1e-6
    assert reported.yaw_max_deg < 1e-6
    assert (reported.rmse_m, reported.max_m) == (by_places.rmse_m, by_places.max_m)
