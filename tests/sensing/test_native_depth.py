"""Kernels of sensing and their NumPy twins agree."""

from __future__ import annotations

import depth_reference as twin
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthBlocks, DepthNoise, GroundSegmentation, RgbdFrame, _native
from circumspect.sensing.floor_plane import FloorPlane
from circumspect.sensing.segmentation import continuous_pixels
from circumspect.simulation import looking_at

NOISE = DepthNoise()
seeds = st.integers(0, 2**32 - 1)


def picture(seed: int, height: int, width: int) -> RgbdFrame:
    """Steps, slopes, noise and holes, from above a floor."""
    rng = np.random.default_rng(seed)
    slopes = np.add.outer(rng.normal(0, 0.01) * np.arange(height), np.arange(width) * 0.004)
    depth = 1.2 + np.abs(slopes) + 0.5 * (rng.random((height, width)) < 0.1)
    depth += rng.normal(0, 0.003, depth.shape)
    depth[rng.random(depth.shape) < 0.1] = np.nan
    camera = PinholeCamera(width, height, 40.0, 42.0, width / 2 - 0.5, height / 2)
    return RgbdFrame(depth, camera, 0.0, looking_at((0.3, -1.0, 1.1), (0.2, 0.0, 0.2)))


pictures = st.builds(picture, seeds, st.integers(1, 40), st.integers(1, 50))


@settings(max_examples=50)
@given(pictures, seeds, st.integers(1, 9), st.booleans())
def test_means_over_blocks(frame: RgbdFrame, seed: int, block: int, masked: bool) -> None:
    mask = np.random.default_rng(seed).random(frame.depth.shape) < 0.7 if masked else None
    found = DepthBlocks.of(frame.depth, frame.camera, block, mask)
    mean, counts = twin.block_means(frame.depth, block, mask, found.jump)
    np.testing.assert_array_equal(found.counts, counts)
    np.testing.assert_allclose(found.inverse_depth, mean, rtol=2e-6)


@settings(max_examples=50)
@given(pictures)
def test_pixels_on_surfaces(frame: RgbdFrame) -> None:
    found = continuous_pixels(frame.depth, frame.camera, NOISE)
    expected = twin.continuous_pixels(frame.depth, frame.camera, NOISE, 1.4)
    # Both are in single precision and may differ where a step is just what is allowed.
    assert (found != expected).mean() < 0.002


@settings(max_examples=50)
@given(pictures, st.floats(-0.05, 0.05), st.floats(-0.05, 0.05))
def test_points_on_the_floor(frame: RgbdFrame, slope: float, offset: float) -> None:
    segmentation, floor = GroundSegmentation(), FloorPlane(slope, -slope, offset)
    mask = frame.valid.copy()
    segmentation._keep_above_floor(frame, floor, mask)
    height, sigma = twin.clearance(frame, floor, NOISE)
    clear = height - segmentation.margin - segmentation.sigmas * sigma
    expected = frame.valid & (frame.depth <= NOISE.farthest) & (clear > 0)
    sure = ~(np.abs(clear) < 1e-5)
    np.testing.assert_array_equal(mask[sure], expected[sure])


@settings(max_examples=50)
@given(pictures, seeds, st.sampled_from([0.04, 0.3]))
def test_cells_of_the_plan(frame: RgbdFrame, seed: int, cell: float) -> None:
    mask = frame.valid & (np.random.default_rng(seed).random(frame.depth.shape) < 0.6)
    camera, pose = frame.camera, frame.pose.as_matrix()
    intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
    cells, counts, low_x, low_y, rows, columns = _native.plan_cells(
        frame.depth, mask, intrinsics, pose, cell
    )
    assert len(cells) == mask.sum()
    assert counts.sum() == len(cells)
    np.testing.assert_array_equal(counts, np.bincount(cells, minlength=rows * columns))
    if len(cells) == 0:
        return
    places, low = twin.plan_places(frame, mask, cell)
    np.testing.assert_allclose([low_x, low_y], low, atol=1e-5)
    found = np.column_stack(np.divmod(cells, columns))
    clear = (np.abs(places - np.round(places)) > 1e-3).all(axis=1)
    np.testing.assert_array_equal(found[clear], np.floor(places[clear]))
    wanted = np.random.default_rng(seed).random(rows * columns) < 0.5
    kept = mask.copy()
    _native.keep_cells(cells, wanted, kept)
    np.testing.assert_array_equal(kept[mask], wanted[cells])
    assert not kept[~mask].any()


@settings(max_examples=50)
@given(pictures, seeds, st.sampled_from([2, 3]))
def test_blocks_have_the_cells_of_their_first_masked_pixels(
    frame: RgbdFrame, seed: int, block: int
) -> None:
    rng = np.random.default_rng(seed)
    mask = frame.valid & (rng.random(frame.depth.shape) < 0.6)
    camera, pose = frame.camera, frame.pose.as_matrix()
    intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
    height, width = mask.shape
    numbers = (np.arange(height)[:, None] // block) * width + np.arange(width) // block
    found, first = np.unique(numbers[mask], return_index=True)
    v, u = np.nonzero(mask)
    firsts = np.zeros_like(mask)
    firsts[v[first], u[first]] = True
    cells, counts, *_, columns = _native.plan_cells(
        frame.depth, mask, intrinsics, pose, 0.04, block
    )
    alone = _native.plan_cells(frame.depth, firsts, intrinsics, pose, 0.04)
    assert len(cells) == len(found)
    assert counts.sum() == mask.sum()
    assert sorted(cells) == sorted(alone[0])
    assert columns == alone[-1]
    wanted, kept = rng.random(len(counts)) < 0.5, mask.copy()
    _native.keep_cells(cells, wanted, kept, block)
    expected = mask & np.isin(numbers, found[wanted[cells]])
    np.testing.assert_array_equal(kept, expected)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("at", [(0, 0), (2, 3), (5, 7)])
def test_a_masked_pixel_without_depth_has_no_place_in_the_plan(bad: float, at: tuple) -> None:
    depth, mask = np.ones((6, 8), np.float32), np.ones((6, 8), bool)
    depth[at] = bad
    camera = (10.0, 10.0, 3.3, 2.2)
    cells, counts, *_, rows, columns = _native.plan_cells(depth, mask, camera, np.eye(4), 0.04)
    assert (len(cells), len(counts), rows, columns) == (0, 0, 0, 0)


@given(pictures, seeds, st.integers(1, 8))
def test_sparse_points_are_those_of_the_sparse_mask(frame, seed: int, step: int) -> None:
    mask = np.random.default_rng(seed).random(frame.depth.shape) < 0.6
    sparse = np.zeros_like(mask)
    sparse[::step, ::step] = mask[::step, ::step]
    np.testing.assert_allclose(
        frame.sparse_points_map(step, mask), frame.points_map(sparse), atol=1e-12
    )


def test_points_too_far_apart_for_any_plan_are_no_object() -> None:
    depth = np.full((40, 50), 1e6)
    camera = PinholeCamera(50, 40, 40.0, 40.0, 24.5, 19.5)
    frame = RgbdFrame(depth, camera, 0.0, looking_at((0.0, -1.0, 1.1), (0.0, 0.0, 1.1)))
    far = GroundSegmentation(noise=DepthNoise(farthest=1e9), sigmas=0.0)
    assert not far.object_mask(frame).any()


def test_arrays_of_another_size_are_refused() -> None:
    depth, mask = np.ones((4, 6), np.float32), np.ones((4, 5), bool)
    noise, four = NOISE.coefficients(PinholeCamera.xtion()), (1.0, 1.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="image's size"):
        _native.continuous(depth, noise, 4.0, 0.01, mask)
    with pytest.raises(ValueError, match="image's size"):
        _native.keep_above(depth, four, four, noise, 0.0, 3.0, 3.5, mask)
    with pytest.raises(ValueError, match="one mean and count a block"):
        _native.block_means(
            depth, None, 2, 0.1, np.ones((1, 3), np.float32), np.ones((1, 3), np.int32)
        )
    with pytest.raises(ValueError, match="one cell a masked block"):
        _native.keep_cells(np.zeros(3, np.int32), np.ones(2, bool), mask)
    with pytest.raises(ValueError, match="known cells"):
        _native.keep_cells(np.full(20, 7, np.int32), np.ones(2, bool), mask)


def other_layouts(shape: tuple[int, int], dtype: type) -> list[np.ndarray]:
    """Outputs of the right size whose layout a kernel could only fill through a copy."""
    rows, columns = shape
    return [
        np.zeros(shape, dtype, order="F"),
        np.zeros((rows, 2 * columns), dtype)[:, ::2],
        np.zeros(shape, np.float64),
    ]


@pytest.mark.parametrize("which", range(3))
def test_outputs_of_another_layout_are_refused(which: int) -> None:
    depth = np.ones((4, 6), np.float32)
    noise, four = NOISE.coefficients(PinholeCamera.xtion()), (1.0, 1.0, 0.0, 0.0)
    mask = other_layouts((4, 6), bool)[which]
    mean, counts = np.zeros((2, 3), np.float32), np.zeros((2, 3), np.int32)
    with pytest.raises(TypeError, match="incompatible function arguments"):
        _native.continuous(depth, noise, 4.0, 0.01, mask)
    with pytest.raises(TypeError, match="incompatible function arguments"):
        _native.keep_above(depth, four, four, noise, 0.0, 3.0, 3.5, mask)
    with pytest.raises(TypeError, match="incompatible function arguments"):
        _native.keep_cells(np.zeros(0, np.int32), np.ones(2, bool), mask)
    for outputs in (
        (other_layouts((2, 3), np.float32)[which], counts),
        (mean, other_layouts((2, 3), np.int32)[which]),
    ):
        with pytest.raises(TypeError, match="incompatible function arguments"):
            _native.block_means(depth, None, 2, 0.1, *outputs)
