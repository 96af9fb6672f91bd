from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from tracking_world import SHORT, T_BASE_CAMERA, short_drive, true_camera

from circumspect.geometry import se3
from circumspect.mapping import FrameSurface, ModelSettings, ObjectModel, ObjectViews, Rebuild
from circumspect.mapping.object_views import ENOUGH, MOST, WAITING
from circumspect.sensing import GroundSegmentation

ANCHORS = [0, 0, 0, 1, 1, 1]
DRIFT = se3.exp([0.0, 0.0, 0.06, 0.05, 0.03, 0.0])
"""What the second keyframe is believed to be off, before it is corrected."""


def fused_both_ways() -> tuple[ObjectModel, ObjectModel]:
    """A model fused with true poses, and one fused with drift and rebuilt from true keyframes."""
    direct, drifted, views = ObjectModel(), ObjectModel(), ObjectViews()
    settings = ModelSettings()
    anchors = {0: true_camera(float(SHORT[0])), 1: true_camera(float(SHORT[3]))}
    for number, anchor in enumerate(ANCHORS):
        frame, true = short_drive()[number], true_camera(float(SHORT[number]))
        mask = GroundSegmentation().object_mask(frame.at(true))
        believed = DRIFT * true if anchor else true
        direct = direct.fused(frame, mask, true)
        surface = FrameSurface.of(frame, mask, believed)
        drifted = drifted.with_surface(surface)
        T_map_anchor = DRIFT * anchors[anchor] if anchor else anchors[anchor]
        views = views.with_share(anchor, T_map_anchor, drifted.share(surface))
    rebuild = Rebuild(views, settings, drifted.voxel, anchors.__getitem__)
    rebuild.go_on()
    assert rebuild.is_whole
    return direct, rebuild.model


def test_the_rebuilt_model_is_the_one_fused_with_the_corrected_poses() -> None:
    direct, rebuilt = fused_both_ways()
    one, other = direct.cloud(), rebuilt.cloud()
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
    np.testing.assert_allclose(rebuilt.views_xyz, direct.views_xyz, atol=1e-6)
    assert rebuilt.sums.totals[:, 7].max() <= len(ANCHORS)
    assert abs(len(rebuilt.rays) / len(direct.rays) - 1) < 0.2


def test_patches_are_bounded() -> None:
    frame = short_drive()[0]
    mask = np.zeros(frame.depth.shape, bool)
    mask[100:104, 100:104] = True
    surface = FrameSurface.of(frame, mask, T_BASE_CAMERA)
    model, views = ObjectModel().with_surface(surface), ObjectViews()
    for anchor in range(MOST + 3):
        views = views.with_share(anchor, T_BASE_CAMERA, model.share(surface))
    assert len(views.patches) == MOST
    assert MOST + 2 in views.patches


def test_a_patch_that_has_enough_frames_takes_no_more_in() -> None:
    """Else a robot that goes round for half an hour gathers the noise of all its frames."""
    frame = short_drive()[0]
    mask = np.zeros(frame.depth.shape, bool)
    mask[100:104, 100:104] = True
    model, views, counts = ObjectModel(), ObjectViews(), []
    for number in range(ENOUGH + 5):
        T_map_camera = se3.exp([0.0, 0.0, 0.0, 0.02 * number, 0.0, 0.0]) * T_BASE_CAMERA
        surface = FrameSurface.of(frame, mask, T_map_camera)
        model = model.with_surface(surface)
        views = views.with_share(0, T_BASE_CAMERA, model.share(surface))
        counts.append((len(views.patches[0].views_xyz), len(views.patches[0].sums.keys)))
    assert [frames for frames, _ in counts[:ENOUGH]] == list(range(1, ENOUGH + 1))
    assert counts[ENOUGH - 1][1] > counts[ENOUGH - 2][1]
    assert set(counts[ENOUGH - 1 :]) == {counts[ENOUGH - 1]}
    # Another keyframe's patch is as open as ever.
    assert 1 in views.with_share(1, T_BASE_CAMERA, model.share(surface)).patches


def test_frames_wait_in_the_latest_patch_only() -> None:
    frame = short_drive()[0]
    mask = np.zeros(frame.depth.shape, bool)
    mask[100:108, 100:108] = True
    model, views = ObjectModel(), ObjectViews()
    for number in range(WAITING + 3):
        T_map_camera = se3.exp([0.0, 0.0, 0.0, 0.02 * number, 0.0, 0.0]) * T_BASE_CAMERA
        surface = FrameSurface.of(frame, mask, T_map_camera)
        share = model.share(surface)
        model, views = model.with_share(share), views.with_share(0, T_BASE_CAMERA, share)
    patch = views.patches[0]
    assert len(patch.waiting) == 3
    np.testing.assert_array_equal(patch.sums.keys, model.sums.keys)
    # Single precision, for all but the last three.
    np.testing.assert_allclose(patch.sums.totals, model.sums.totals, rtol=1e-5, atol=1e-2)
    later = views.with_share(1, T_BASE_CAMERA, model.share(surface))
    assert later.latest == 1
    assert [len(patch.waiting) for patch in later.patches.values()] == [0, 1]
    np.testing.assert_array_equal(later.patches[0].sums.keys, model.sums.keys)


def test_a_rebuild_a_few_patches_at_a_time_is_the_one_at_once() -> None:
    frame = short_drive()[0]
    mask = GroundSegmentation().object_mask(frame.at(T_BASE_CAMERA))
    surface = FrameSurface.of(frame, mask, T_BASE_CAMERA)
    model, views = ObjectModel().with_surface(surface), ObjectViews()
    places = {n: se3.exp([0.0, 0.0, 0.02 * n, 0.0, 0.0, 0.0]) * T_BASE_CAMERA for n in range(5)}
    for number in places:
        views = views.with_share(number, T_BASE_CAMERA, model.share(surface))
    del places[3]  # forgotten long ago
    at_once, bit_by_bit = (
        Rebuild(views, ModelSettings(), model.voxel, places.__getitem__) for _ in range(2)
    )
    at_once.go_on()
    assert at_once.is_whole
    size = len(views.patches[0])
    for voxels, whole in ((0, False), (3 * size, False), (size - 1, False), (1, True)):
        bit_by_bit.go_on(voxels)
        assert bit_by_bit.is_whole == whole
    assert at_once.model.frames == bit_by_bit.model.frames == 4
    np.testing.assert_array_equal(at_once.model.points_xyz, bit_by_bit.model.points_xyz)


def test_no_views_make_an_empty_model() -> None:
    rebuild = Rebuild(ObjectViews(), ModelSettings(), 0.01, {}.__getitem__)
    assert rebuild.is_whole
    assert rebuild.model.frames == 0
    assert len(rebuild.model.points_xyz) == 0
