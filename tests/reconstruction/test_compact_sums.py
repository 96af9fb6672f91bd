"""Compact sums take half the memory, with errors below the resolution of a camera."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from tracking_world import T_BASE_CAMERA, short_drive

from circumspect.geometry.voxel_sums import VoxelSums
from circumspect.reconstruction import FrameSurface, ObjectModel, SubmapCollection
from circumspect.reconstruction.frame_contribution import COLUMNS, FRAMES, NORMAL, POINT, WEIGHT
from circumspect.reconstruction.submap import CompactSums
from circumspect.sensing import GroundSegmentation


def sums_about(centre_xyz: np.ndarray, seed: int, count: int = 50) -> VoxelSums:
    rng = np.random.default_rng(seed)
    weights = rng.uniform(1e3, 1e7, count)
    totals = np.zeros((count, COLUMNS))
    totals[:, WEIGHT] = weights
    totals[:, POINT] = weights[:, None] * (centre_xyz + rng.uniform(-3, 3, (count, 3)))
    totals[:, NORMAL] = weights[:, None] * rng.uniform(-1, 1, (count, 3))
    totals[:, FRAMES] = rng.integers(1, 3600, count)
    return VoxelSums(np.arange(count), totals)


@given(
    st.integers(0, 2**31),
    st.lists(st.floats(-1e5, 1e5), min_size=3, max_size=3).map(np.array),
)
def test_mean_points_are_accurate_at_any_distance_from_the_origin(
    seed: int, centre: np.ndarray
) -> None:
    sums = sums_about(centre, seed)
    back = CompactSums.from_sums(sums, centre + 1.0).expanded()
    means = [s.totals[:, POINT] / s.totals[:, WEIGHT, None] for s in (sums, back)]
    np.testing.assert_allclose(means[1], means[0], atol=2e-6)
    np.testing.assert_allclose(back.totals[:, NORMAL], sums.totals[:, NORMAL], rtol=1e-6)
    np.testing.assert_array_equal(back.totals[:, FRAMES], sums.totals[:, FRAMES])
    np.testing.assert_array_equal(back.keys, sums.keys)


def test_rounding_errors_do_not_accumulate_over_thousands_of_frames() -> None:
    sums = sums_about(np.zeros(3), 0)
    one = VoxelSums(sums.keys, sums.totals / 1000)
    kept = CompactSums.from_sums(VoxelSums.empty(COLUMNS), np.ones(3))
    for _ in range(2000):
        kept = CompactSums.from_sums(kept.expanded().plus(one), np.ones(3))
    means = [s.totals[:, POINT] / s.totals[:, WEIGHT, None] for s in (sums, kept.expanded())]
    np.testing.assert_allclose(means[1], means[0], atol=5e-6)


def test_submap_takes_half_the_memory_of_the_sums() -> None:
    frame = short_drive()[0]
    mask = GroundSegmentation().object_mask(frame.at(T_BASE_CAMERA))
    surface = FrameSurface.from_frame(frame, mask, T_BASE_CAMERA)
    model = ObjectModel().with_surface(surface)
    submaps = SubmapCollection().with_contribution(0, T_BASE_CAMERA, model.contribution(surface))
    assert submaps.submaps[0].compacted().compact.means.nbytes == model.sums.totals.nbytes / 2
