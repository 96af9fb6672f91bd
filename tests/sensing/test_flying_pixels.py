from __future__ import annotations

import numpy as np

from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise, continuous_pixels

CAMERA = PinholeCamera.xtion()
NOISE = DepthNoise()


def step_image() -> np.ndarray:
    depth = np.full((480, 640), 1.0, np.float32)
    depth[:, 320:] = 2.0
    return depth


def test_a_clean_step_keeps_every_pixel() -> None:
    assert continuous_pixels(step_image(), CAMERA, NOISE).all()


def test_only_pixels_between_edge_and_background_are_removed() -> None:
    depth = step_image()
    flying = np.zeros(depth.shape, bool)
    flying[10:470:3, 320] = True
    depth[flying] = 1.4
    kept = continuous_pixels(depth, CAMERA, NOISE)
    assert not kept[flying].any()
    assert kept[~flying].mean() > 0.999


def test_a_veil_two_pixels_wide_is_removed() -> None:
    depth = step_image()
    depth[:, 320], depth[:, 321] = 1.3, 1.6
    kept = continuous_pixels(depth, CAMERA, NOISE)
    assert not kept[:, 320:322].any()
    assert kept[:, :320].all()
    assert kept[:, 322:].all()


def test_a_noisy_slope_is_kept() -> None:
    rng = np.random.default_rng(0)
    normal = np.array([0.0, np.sin(1.0), np.cos(1.0)])
    depth = (1.2 / (CAMERA.rays_xyz @ normal)).astype(np.float32)
    depth[(depth > 3.0) | (depth < 0)] = np.nan
    noisy = depth + NOISE.axial_sigma(depth) * rng.standard_normal(depth.shape).astype(np.float32)
    assert continuous_pixels(noisy, CAMERA, NOISE)[np.isfinite(depth)].mean() > 0.995


def test_isolated_pixels_are_removed() -> None:
    depth = np.full((480, 640), np.nan, np.float32)
    depth[100, 100] = 1.0
    assert not continuous_pixels(depth, CAMERA, NOISE).any()
