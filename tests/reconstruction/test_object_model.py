from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
import trimesh
from box_world import BOX, CAMERA, HIGH, LOW, SEEN_AREA, box_shots, fused
from scipy.spatial import cKDTree
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import read_cloud
from circumspect.grid import FREE, OCCUPIED, CylindricalGrid
from circumspect.reconstruction import ModelSettings, ObjectModel, object_model
from circumspect.sensing import DepthNoise, RgbdFrame
from circumspect.simulation import Scene, SimulatedCamera, Station, block, looking_at


def distance_to_box(points_xyz: np.ndarray) -> np.ndarray:
    """Distance of points to the surface of the box."""
    outside = np.maximum(np.maximum(np.array(LOW) - points_xyz, points_xyz - np.array(HIGH)), 0)
    inside = np.minimum(points_xyz - LOW, np.array(HIGH) - points_xyz).min(axis=1)
    return np.where(inside > 0, inside, np.linalg.norm(outside, axis=1))


@pytest.fixture(scope="module")
def exact() -> ObjectModel:
    return fused(box_shots(12))


def test_exact_frames_reconstruct_the_complete_surface(exact: ObjectModel) -> None:
    cloud = exact.cloud()
    # Means over a voxel that holds an edge lie inside the edge.
    assert np.quantile(distance_to_box(cloud.points_xyz), 0.95) < 5e-4
    surface = BOX.sampled(4000).points_xyz
    observed = surface[surface[:, 2] > 0.01]
    gaps, _ = cKDTree(cloud.points_xyz).query(observed)
    assert (gaps < 0.012).mean() > 0.98


def test_errors_of_the_model_are_below_the_sensor_noise(exact: ObjectModel) -> None:
    noisy = fused(box_shots(12, DepthNoise()))
    distances = distance_to_box(noisy.cloud().points_xyz)
    assert np.median(distances) < 0.003
    assert np.quantile(distances, 0.95) < 0.010


def test_normals_point_outward(exact: ObjectModel) -> None:
    cloud = exact.cloud()
    assert cloud.normals_xyz is not None
    faces = {
        0: cloud.points_xyz[:, 0] > 0.2499,
        1: cloud.points_xyz[:, 1] < -0.3499,
        2: cloud.points_xyz[:, 2] > 0.5999,
    }
    for axis, on_face in faces.items():
        outward = cloud.normals_xyz[on_face, axis] * (-1 if axis == 1 else 1)
        assert on_face.sum() > 100
        assert np.median(outward) > 0.999
        assert (outward > 0.7).mean() > 0.9


def test_areas_sum_to_the_observed_surface(exact: ObjectModel) -> None:
    areas = exact.cloud().areas
    assert areas is not None
    assert areas.sum() == pytest.approx(SEEN_AREA, rel=0.1)


def test_repeated_views_from_one_side_do_not_shift_the_centre(exact: ObjectModel) -> None:
    model = exact
    frame, mask = next(box_shots(1))
    for _ in range(20):
        model = model.fused(frame, mask, frame.pose)
    before, after = (m.cloud().weights @ m.cloud().points_xyz for m in (exact, model))
    np.testing.assert_allclose(after[:2], before[:2], atol=0.004)


def test_a_close_view_does_not_shift_the_centre(exact: ObjectModel) -> None:
    camera = SimulatedCamera(Scene.with_object(BOX), lambda: station, CAMERA)
    station = Station(0.0, looking_at([0.75, 0.0, 0.4], [0, 0, 0.3]))
    frame = camera.capture()
    mask = camera.truth(station).surface == 0
    model = exact.fused(frame, mask, frame.pose)
    before, after = (m.cloud().weights @ m.cloud().points_xyz for m in (exact, model))
    np.testing.assert_allclose(after, before, atol=0.006)


def test_weighted_centre_equals_that_of_the_observed_surface(exact: ObjectModel) -> None:
    cloud = exact.cloud()
    centre = cloud.weights @ cloud.points_xyz
    sides = 2 * 0.6 * 1.2
    expected = (sides * 0.3 + 0.35 * 0.6) / (sides + 0.35)
    np.testing.assert_allclose(centre, [0, 0, expected], atol=0.012)


def test_model_is_equivariant_to_translation() -> None:
    # By whole blocks of three voxels, so that the same points share the same.
    moved = RigidTransform.from_translation([0.96, -1.92, 0.48])
    shots = list(box_shots(2, mesh=block(LOW, (0.25, 0.35, 0.603))))
    here = fused(shots)
    there = fused([(frame.at(moved * frame.pose), mask) for frame, mask in shots])
    gaps, _ = cKDTree(there.cloud().points_xyz - [0.96, -1.92, 0.48]).query(here.cloud().points_xyz)
    assert np.quantile(gaps, 0.99) < 1e-3


def test_the_order_of_frames_does_not_matter() -> None:
    shots = list(box_shots(4))
    one, other = fused(shots).cloud(), fused(shots[::-1]).cloud()
    np.testing.assert_allclose(one.points_xyz, other.points_xyz, atol=1e-9)
    np.testing.assert_allclose(one.weights, other.weights, atol=1e-12)


def test_fused_returns_a_new_model() -> None:
    frame, mask = next(box_shots(1))
    empty = ObjectModel()
    model = empty.fused(frame, mask, frame.pose)
    assert (empty.frames, len(empty.sums), len(empty.rays)) == (0, 0, 0)
    assert model.frames == 1


def test_repeating_a_frame_changes_no_point_and_adds_no_ray() -> None:
    frame, mask = next(box_shots(1))
    once = ObjectModel().fused(frame, mask, frame.pose)
    twice = once.fused(frame, mask, frame.pose)
    np.testing.assert_allclose(twice.points_xyz, once.points_xyz, atol=1e-9)
    assert len(twice.rays) == len(once.rays)


def test_outliers_and_points_observed_once_are_removed() -> None:
    shots = list(box_shots(10))
    frame, mask = shots[3]
    depth = frame.depth.copy()
    depth[100:104, 4:8] = 1.0
    outlier = np.zeros_like(mask)
    outlier[100:104, 4:8] = True
    shots[3] = (RgbdFrame(depth, CAMERA, 0.0, frame.pose), mask | outlier)
    model = fused(shots)
    far_off = distance_to_box(model.points_xyz) > 0.05
    assert far_off.any()
    assert not (distance_to_box(model.cloud().points_xyz) > 0.05).any()


def test_a_mask_without_depth_changes_nothing() -> None:
    frame = RgbdFrame(np.full((240, 320), np.nan), CAMERA, 0.0, RigidTransform.identity())
    model = ObjectModel()
    assert model.fused(frame, np.ones((240, 320), bool), frame.pose) is model


def test_an_empty_model_has_no_cloud() -> None:
    with pytest.raises(GeometryError, match="empty"):
        ObjectModel().cloud()


def test_number_of_rays_is_bounded_over_repeated_rounds() -> None:
    shots = list(box_shots(6, DepthNoise()))
    once = fused(shots)
    twice, often = fused(shots * 2), fused(shots * 4)
    # The second round adds a few rays past points that were unknown in the first.
    assert len(twice.rays) < 1.02 * len(once.rays)
    assert len(often.rays) == len(twice.rays)
    assert len(often.sums) == len(twice.sums) == len(once.sums)


def test_a_small_model_is_its_own_preview(exact: ObjectModel) -> None:
    assert exact.preview is exact
    assert ObjectModel().preview.frames == 0


def test_a_past_model_is_freed_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the cycle collector: hundreds of models would accumulate until it runs."""

    def past() -> ObjectModel | None:
        model = fused(box_shots(2))
        assert len(model.preview.cloud()) > 0
        kept = weakref.ref(model)
        del model
        return kept()

    gc.disable()
    try:
        assert past() is None
        monkeypatch.setattr(object_model, "MAX_FINE_VOXELS", 1000)
        assert past() is None
    finally:
        gc.enable()


@pytest.mark.parametrize("pending", [0, 20_000, 10**9])
def test_a_large_model_is_unchanged_and_its_preview_is_close_to_it(
    pending: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For any number of pending frames."""
    shots = list(box_shots(12, DepthNoise()))
    plain = fused(shots)
    monkeypatch.setattr(object_model, "MAX_FINE_VOXELS", 5000)
    monkeypatch.setattr(object_model, "MAX_PENDING_ROWS", pending)
    large = fused(shots)
    assert bool(large.pending) == (pending > 0)
    np.testing.assert_array_equal(large.sums.keys, plain.sums.keys)
    np.testing.assert_array_equal(large.sums.totals, plain.sums.totals)
    preview = large.preview
    assert preview.voxel == 2 * large.voxel
    assert preview.frames == large.frames
    assert 0.2 < len(preview.sums) / len(large.sums) < 0.35
    assert preview.sums.totals[:, 7].max() <= large.frames
    np.testing.assert_allclose(preview.sums.totals[:, :7].sum(0), large.sums.totals[:, :7].sum(0))
    cloud, rough = large.cloud(), preview.cloud()
    gaps, _ = cKDTree(rough.points_xyz).query(cloud.points_xyz)
    assert np.quantile(gaps, 0.99) < 2 * large.voxel
    assert np.median(distance_to_box(rough.points_xyz)) < 0.005
    np.testing.assert_allclose(rough.areas.sum(), cloud.areas.sum(), rtol=0.05)
    grid = CylindricalGrid.fit(cloud)
    fine, few = large.occupancy(grid).states, preview.occupancy(grid).states
    assert (fine == few).mean() > 0.97


def test_grid_is_occupied_at_the_surface_and_free_beside_it(exact: ObjectModel) -> None:
    grid = CylindricalGrid.fit(exact.cloud())
    states = exact.occupancy(grid).states
    np.testing.assert_array_equal(states == OCCUPIED, grid.hits(exact.cloud()).occupied)
    rng = np.random.default_rng(0)
    around = rng.uniform([-0.4, -0.4, 0.05], [0.4, 0.4, 0.8], (4000, 3))
    cells = grid.indices(around)
    inside_grid = cells[:, 0] >= 0
    state = states[tuple(cells[inside_grid].T)]
    points = around[inside_grid]
    # Further from the surface than the largest cell is long.
    apart = distance_to_box(points) > 0.1
    in_box = ((points > LOW) & (points < HIGH)).all(axis=1)
    assert (state[in_box & apart] == 0).all(), "no frame observed the inside of the box"
    assert (state[~in_box & apart] == FREE).mean() > 0.97


def test_floor_is_not_occupied(exact: ObjectModel) -> None:
    grid = CylindricalGrid(radius=0.8, half_height=0.8, centre_xyz=(0, 0, 0.3))
    states = exact.occupancy(grid).states
    rng = np.random.default_rng(0)
    floor = np.column_stack([rng.uniform(-0.56, 0.56, (4000, 2)), np.zeros(4000)])
    beside = floor[(np.abs(floor[:, 0]) > 0.35) | (np.abs(floor[:, 1]) > 0.45)]
    cells = grid.indices(beside)
    assert (states[tuple(cells.T)] != OCCUPIED).all()


def test_saved_cloud_reads_back(exact: ObjectModel, tmp_path) -> None:
    exact.save(tmp_path / "model.ply")
    back = read_cloud(tmp_path / "model.ply")
    np.testing.assert_allclose(back.points_xyz, exact.cloud().points_xyz, atol=1e-6)


def test_other_programs_read_the_frame_counts(exact, tmp_path) -> None:
    exact.save(tmp_path / "model.ply")
    loaded = trimesh.load(tmp_path / "model.ply")
    counts = loaded.metadata["_ply_raw"]["vertex"]["data"]["frames"]
    np.testing.assert_array_equal(np.ravel(counts), exact.frames_seen())
    assert counts.max() > 1


def test_voxel_setting_is_used() -> None:
    shots = list(box_shots(2))
    coarse = ObjectModel(ModelSettings(voxel=0.03))
    for frame, mask in shots:
        coarse = coarse.fused(frame, mask, frame.pose)
    assert len(coarse.sums) < 0.3 * len(fused(shots).sums)


@pytest.mark.parametrize(("distance", "voxel"), [(0.4, 0.006), (1.5, 0.010), (6.0, 0.012)])
def test_default_voxel_scales_with_the_distance_of_the_first_frame(
    distance: float, voxel: float
) -> None:
    wall = RgbdFrame(np.full((240, 320), distance), CAMERA, 0.0, RigidTransform.identity())
    middle = np.zeros((240, 320), bool)
    middle[100:140, 140:180] = True
    model = ObjectModel().fused(wall, middle, wall.pose)
    assert model.voxel == pytest.approx(voxel, abs=0.0011)
    nearer = RgbdFrame(wall.depth / 2, CAMERA, 1.0, wall.T_map_camera)
    assert model.fused(nearer, middle, wall.pose).voxel == model.voxel


def test_a_turned_camera_sees_the_same_surface() -> None:
    frame, mask = next(box_shots(1))
    upside_down = RigidTransform.from_rotation(Rotation.from_euler("z", 180, degrees=True))
    turned = RgbdFrame(frame.depth[::-1, ::-1], CAMERA, 0.0, frame.pose * upside_down)
    one = ObjectModel().fused(frame, mask, frame.pose)
    other = ObjectModel().fused(turned, mask[::-1, ::-1], turned.pose)
    gaps, _ = cKDTree(other.points_xyz).query(one.points_xyz)
    assert np.quantile(gaps, 0.99) < 2e-3


def test_a_model_in_place_of_its_cloud_is_an_error() -> None:
    with pytest.raises(InputError, match=r"not an object of ObjectModel; take .*\.cloud\(\)"):
        CylindricalGrid.fit(ObjectModel())
