from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from tracking_world import SHORT, T_BASE_CAMERA, short_drive, true_camera

from circumspect.geometry import se3
from circumspect.reconstruction import (
    FrameSurface,
    ModelSettings,
    ObjectModel,
    SubmapCollection,
    SubmapFusion,
)
from circumspect.reconstruction.submap import MAX_PENDING_FRAMES, MAX_SUBMAP_FRAMES, MAX_SUBMAPS
from circumspect.sensing import GroundSegmentation

KEYFRAMES = [0, 0, 0, 1, 1, 1]
"""Reference keyframe of each frame."""
DRIFT = se3.exp([0.0, 0.0, 0.06, 0.05, 0.03, 0.0])
"""Error of the second keyframe before its correction."""


def fused_both_ways() -> tuple[ObjectModel, ObjectModel]:
    """A model fused at true poses, and one fused from submaps after a correction."""
    direct, drifted, submaps = ObjectModel(), ObjectModel(), SubmapCollection()
    settings = ModelSettings()
    corrected = {0: true_camera(float(SHORT[0])), 1: true_camera(float(SHORT[3]))}
    for number, keyframe in enumerate(KEYFRAMES):
        frame, true = short_drive()[number], true_camera(float(SHORT[number]))
        mask = GroundSegmentation().object_mask(frame.at(true))
        estimated = DRIFT * true if keyframe else true
        direct = direct.fused(frame, mask, true)
        surface = FrameSurface.from_frame(frame, mask, estimated)
        drifted = drifted.with_surface(surface)
        T_map_keyframe = DRIFT * corrected[keyframe] if keyframe else corrected[keyframe]
        contribution = drifted.contribution(surface)
        submaps = submaps.with_contribution(keyframe, T_map_keyframe, contribution)
    fusion = SubmapFusion(submaps, settings, drifted.voxel, corrected.__getitem__)
    fusion.fuse_pending()
    assert fusion.is_complete
    return direct, fusion.model


def test_fusion_of_submaps_equals_fusion_at_corrected_poses() -> None:
    direct, fused = fused_both_ways()
    one, other = direct.cloud(), fused.cloud()
    for a, b in ((one, other), (other, one)):
        gaps, _ = cKDTree(a.points_xyz).query(b.points_xyz)
        assert np.median(gaps) < 0.003
        assert np.quantile(gaps, 0.98) < direct.voxel
    assert one.areas is not None
    assert other.areas is not None
    np.testing.assert_allclose(other.areas.sum(), one.areas.sum(), rtol=0.12)
    np.testing.assert_allclose(
        one.weights @ one.points_xyz, other.weights @ other.points_xyz, atol=0.012
    )
    np.testing.assert_allclose(fused.views_xyz, direct.views_xyz, atol=1e-6)
    assert fused.sums.totals[:, 7].max() <= len(KEYFRAMES)
    assert abs(len(fused.rays) / len(direct.rays) - 1) < 0.2


def test_number_of_submaps_is_bounded() -> None:
    frame = short_drive()[0]
    mask = np.zeros(frame.depth.shape, bool)
    mask[100:104, 100:104] = True
    surface = FrameSurface.from_frame(frame, mask, T_BASE_CAMERA)
    model, submaps = ObjectModel().with_surface(surface), SubmapCollection()
    for keyframe in range(MAX_SUBMAPS + 3):
        submaps = submaps.with_contribution(keyframe, T_BASE_CAMERA, model.contribution(surface))
    assert len(submaps.submaps) == MAX_SUBMAPS
    assert MAX_SUBMAPS + 2 in submaps.submaps


def test_full_submap_ignores_further_frames() -> None:
    """Otherwise the noise of all frames accumulates in a run of half an hour."""
    frame = short_drive()[0]
    mask = np.zeros(frame.depth.shape, bool)
    mask[100:104, 100:104] = True
    model, submaps, counts = ObjectModel(), SubmapCollection(), []
    for number in range(MAX_SUBMAP_FRAMES + 5):
        T_map_camera = se3.exp([0.0, 0.0, 0.0, 0.02 * number, 0.0, 0.0]) * T_BASE_CAMERA
        surface = FrameSurface.from_frame(frame, mask, T_map_camera)
        model = model.with_surface(surface)
        submaps = submaps.with_contribution(0, T_BASE_CAMERA, model.contribution(surface))
        submap = submaps.submaps[0]
        counts.append((len(submap.views_xyz), len(submap.sums.keys)))
    frames = [frames for frames, _ in counts[:MAX_SUBMAP_FRAMES]]
    assert frames == list(range(1, MAX_SUBMAP_FRAMES + 1))
    full = counts[MAX_SUBMAP_FRAMES - 1]
    assert full[1] > counts[MAX_SUBMAP_FRAMES - 2][1]
    assert set(counts[MAX_SUBMAP_FRAMES - 1 :]) == {full}
    # The submaps of other keyframes are not affected.
    other = submaps.with_contribution(1, T_BASE_CAMERA, model.contribution(surface))
    assert 1 in other.submaps


def test_only_the_latest_submap_has_pending_frames() -> None:
    frame = short_drive()[0]
    mask = np.zeros(frame.depth.shape, bool)
    mask[100:108, 100:108] = True
    model, submaps = ObjectModel(), SubmapCollection()
    for number in range(MAX_PENDING_FRAMES + 3):
        T_map_camera = se3.exp([0.0, 0.0, 0.0, 0.02 * number, 0.0, 0.0]) * T_BASE_CAMERA
        surface = FrameSurface.from_frame(frame, mask, T_map_camera)
        contribution = model.contribution(surface)
        model = model.with_contribution(contribution)
        submaps = submaps.with_contribution(0, T_BASE_CAMERA, contribution)
    submap = submaps.submaps[0]
    assert len(submap.pending) == 3
    np.testing.assert_array_equal(submap.sums.keys, model.sums.keys)
    # All but the last three frames are stored in single precision.
    np.testing.assert_allclose(submap.sums.totals, model.sums.totals, rtol=1e-5, atol=1e-2)
    later = submaps.with_contribution(1, T_BASE_CAMERA, model.contribution(surface))
    assert later.latest == 1
    assert [len(submap.pending) for submap in later.submaps.values()] == [0, 1]
    np.testing.assert_array_equal(later.submaps[0].sums.keys, model.sums.keys)


def test_fusion_in_steps_equals_fusion_at_once() -> None:
    frame = short_drive()[0]
    mask = GroundSegmentation().object_mask(frame.at(T_BASE_CAMERA))
    surface = FrameSurface.from_frame(frame, mask, T_BASE_CAMERA)
    model, submaps = ObjectModel().with_surface(surface), SubmapCollection()
    poses = {n: se3.exp([0.0, 0.0, 0.02 * n, 0.0, 0.0, 0.0]) * T_BASE_CAMERA for n in range(5)}
    for number in poses:
        submaps = submaps.with_contribution(number, T_BASE_CAMERA, model.contribution(surface))
    del poses[3]  # culled
    at_once, in_steps = (
        SubmapFusion(submaps, ModelSettings(), model.voxel, poses.__getitem__) for _ in range(2)
    )
    at_once.fuse_pending()
    assert at_once.is_complete
    size = len(submaps.submaps[0])
    for voxels, complete in ((0, False), (3 * size, False), (size - 1, False), (1, True)):
        in_steps.fuse_pending(voxels)
        assert in_steps.is_complete == complete
    assert at_once.model.frames == in_steps.model.frames == 4
    np.testing.assert_array_equal(at_once.model.points_xyz, in_steps.model.points_xyz)


def test_fusion_without_submaps_gives_an_empty_model() -> None:
    fusion = SubmapFusion(SubmapCollection(), ModelSettings(), 0.01, {}.__getitem__)
    assert fusion.is_complete
    assert fusion.model.frames == 0
    assert len(fusion.model.points_xyz) == 0
