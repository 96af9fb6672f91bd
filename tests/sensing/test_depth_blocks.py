from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthBlocks

CAMERA = PinholeCamera(64, 48, 60.0, 62.0, 31.5, 23.5)
RAYS = CAMERA.rays_xyz


def plane_depth(normal: np.ndarray, distance: float) -> np.ndarray:
    """Depth of the plane normal · x = distance."""
    return (distance / (RAYS @ normal)).astype(np.float32)


@settings(deadline=None)
@given(
    x=st.floats(-0.4, 0.4), y=st.floats(-0.4, 0.4), distance=st.floats(0.5, 4.0),
    block=st.sampled_from([1, 2, 4]),
)  # fmt: skip
def test_points_and_normals_of_a_plane_are_exact(
    x: float, y: float, distance: float, block: int
) -> None:
    normal = np.array([x, y, 1.0]) / np.linalg.norm([x, y, 1.0])
    blocks = DepthBlocks.of(plane_depth(normal, distance), CAMERA, block)
    whole = blocks.counts == block**2
    points, normals = blocks.points_xyz(*np.nonzero(whole)), blocks.normals()[whole]
    assert len(points) > 0.8 * whole.size
    np.testing.assert_allclose(points @ normal, distance, rtol=2e-4)
    np.testing.assert_allclose(normals, np.broadcast_to(-normal, normals.shape), atol=4e-3)


@given(seed=st.integers(0, 1000), block=st.integers(1, 5))
@settings(deadline=None, max_examples=30)
def test_means_equal_those_of_a_loop(seed: int, block: int) -> None:
    rng = np.random.default_rng(seed)
    depth = rng.uniform(1.0, 1.06, (48, 64)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.5] = np.nan
    mask = rng.random(depth.shape) < 0.8
    blocks = DepthBlocks.of(depth, CAMERA, block, mask)
    for row in range(0, blocks.counts.shape[0], 3):
        for column in range(0, blocks.counts.shape[1], 3):
            window = (
                slice(row * block, (row + 1) * block),
                slice(column * block, (column + 1) * block),
            )
            inside = depth[window][mask[window] & np.isfinite(depth[window])]
            assert blocks.counts[row, column] == len(inside)
            if len(inside):
                assert blocks.inverse_depth[row, column] == pytest.approx(
                    (1 / inside).mean(), rel=1e-5
                )
            else:
                assert np.isnan(blocks.inverse_depth[row, column])


def test_neither_means_nor_normals_cross_a_jump() -> None:
    depth = np.full((48, 64), 1.0, np.float32)
    depth[:, 30:] = 2.0
    blocks = DepthBlocks.of(depth, CAMERA, 4)
    assert (blocks.counts[:, 7] == 0).all()
    normals = blocks.normals()
    np.testing.assert_allclose(normals[:, :7], np.broadcast_to([0, 0, -1], (12, 7, 3)), atol=1e-6)
    np.testing.assert_allclose(normals[:, 8:], np.broadcast_to([0, 0, -1], (12, 8, 3)), atol=1e-6)


def test_an_empty_image_has_no_blocks() -> None:
    blocks = DepthBlocks.of(np.full((48, 64), np.nan, np.float32), CAMERA, 4)
    assert not blocks.counts.any()
    assert np.isnan(blocks.normals()).all()
