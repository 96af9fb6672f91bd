"""The distortion of a camera against its description."""

from __future__ import annotations

import numpy as np
import pytest

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise
from circumspect.simulation import (
    DepthDistortion,
    Scene,
    SimulatedCamera,
    Station,
    block,
    looking_at,
)

CAMERA = PinholeCamera.xtion()
SMALL = PinholeCamera(160, 120, 142.5, 142.5, 79.5, 59.5)
NOISE = DepthNoise()


def test_the_error_is_as_large_as_the_description_says() -> None:
    distortion = DepthDistortion.drawn(NOISE, CAMERA, 0)
    for depth in (1.0, 2.0, 3.0):
        wall = np.full((CAMERA.height, CAMERA.width), depth, np.float32)
        error = distortion.applied(wall) - depth
        expected = NOISE.systematic_sigma(np.array([depth]))[0]
        assert error.std() == pytest.approx(expected, rel=0.02)


def test_errors_are_correlated_between_neighbouring_pixels_only() -> None:
    errors = DepthDistortion.drawn(NOISE, CAMERA, 1).errors
    near = errors[:, 1:] - errors[:, :-1]
    far = errors[:, 200:] - errors[:, :-200]
    assert near.std() < 0.1 * errors.std()
    assert far.std() == pytest.approx(np.sqrt(2) * errors.std(), rel=0.15)


def test_tilts_are_as_large_as_a_scan_expects() -> None:
    """Slopes of a wall at 2 m have the variance 4/3 ς² / (p z)²."""
    depth = 2.0
    wall = np.full((CAMERA.height, CAMERA.width), depth, np.float32)
    slopes = []
    for seed in range(8):
        image = DepthDistortion.drawn(NOISE, CAMERA, seed).applied(wall)
        slopes.append(np.diff(image, axis=1) * CAMERA.fx / depth)
    expected = 4 / 3 * NOISE.systematic_sigma(np.array([depth]))[0] ** 2
    expected /= (NOISE.systematic_patch * depth) ** 2
    # The scan's figure is for nodes with the whole error, this pattern is scaled up to it.
    assert np.mean(np.square(slopes)) == pytest.approx(expected * 1.5**2, rel=0.3)


def test_missing_depth_stays_missing() -> None:
    blind = np.full((CAMERA.height, CAMERA.width), np.nan, np.float32)
    assert np.isnan(DepthDistortion.drawn(NOISE, CAMERA, 0).applied(blind)).all()


def test_the_same_seed_gives_the_same_camera() -> None:
    one, same, other = (DepthDistortion.drawn(NOISE, CAMERA, seed).errors for seed in (3, 3, 4))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


def test_a_distorted_camera_distorts_the_true_depth() -> None:
    scene, station = Scene.with_object(block((-1, -1, 0), (1, 1, 1))), seen_from_the_side()
    distortion = DepthDistortion.drawn(NOISE, SMALL, 0)
    camera = SimulatedCamera(scene, lambda: station, SMALL, distortion=distortion)
    truth = camera.truth(station).depth
    np.testing.assert_array_equal(camera.capture().depth, distortion.applied(truth))
    assert np.nanmax(np.abs(camera.capture().depth - truth)) > 1e-3


def test_the_distortion_of_another_image_size_is_refused() -> None:
    distortion = DepthDistortion.drawn(NOISE, SMALL, 0)
    with pytest.raises(InputError, match="160 x 120 pixels, the camera 640 x 480"):
        SimulatedCamera(
            Scene.with_object(block((-1, -1, 0), (1, 1, 1))), seen_from_the_side, CAMERA,
            distortion=distortion,
        )  # fmt: skip


def seen_from_the_side() -> Station:
    return Station(0.0, looking_at([3.0, 0.0, 1.0], [0.0, 0.0, 0.5]))
