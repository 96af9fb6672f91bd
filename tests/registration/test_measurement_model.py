"""What a scan's points inform: white, systematic and tilt errors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import PinholeCamera
from circumspect.registration import DownsamplingSettings, Scan
from circumspect.sensing import DepthNoise, RgbdFrame

CAMERA = PinholeCamera.xtion()


def wall(depth: float) -> RgbdFrame:
    image = np.full((CAMERA.height, CAMERA.width), depth, np.float32)
    return RgbdFrame(image, CAMERA, 0.0)


def settings(
    voxel: float, systematic: float = DepthNoise().systematic_disparity
) -> DownsamplingSettings:
    return DownsamplingSettings(
        voxel=voxel, max_depth=10.0, noise=DepthNoise(systematic_disparity=systematic)
    )


def information(scan: Scan) -> float:
    """[1/m²] about a motion along the optical axis."""
    return float((1 / (scan.sigmas**2 * scan.correlations)).sum())


@given(st.floats(0.5, 3.4))
def test_more_points_of_a_patch_do_not_inform_beyond_its_systematic_error(depth: float) -> None:
    """At any resolution a wall is known as well as its patches are, and no better."""
    patches = (CAMERA.width / 30 + 2) * (CAMERA.height / 30 + 2)
    bound = patches / DepthNoise().systematic_sigma(np.array([depth]))[0] ** 2
    for voxel in (0.01, 0.03):
        assert information(Scan.from_frame(wall(depth), settings(voxel))) <= bound


def test_the_information_of_a_far_surface_hardly_depends_on_the_voxel() -> None:
    fine, coarse = (
        information(Scan.from_frame(wall(3.0), settings(voxel))) for voxel in (0.01, 0.04)
    )
    assert fine < 1.5 * coarse
    # Without systematic errors every point would inform on its own.
    fine, coarse = (
        information(Scan.from_frame(wall(3.0), settings(voxel, 0.0))) for voxel in (0.01, 0.04)
    )
    assert fine > 3 * coarse


def test_near_surfaces_inform_more_than_far_ones() -> None:
    near, far = (information(Scan.from_frame(wall(z), settings(0.03))) for z in (1.0, 3.0))
    assert near > 10 * far


def test_without_systematic_errors_only_the_white_noise_counts() -> None:
    scan = Scan.from_frame(wall(1.5), settings(0.03, 0.0))
    np.testing.assert_allclose(scan.sigmas, DepthNoise().axial_sigma(np.array([1.5]))[0], rtol=1e-6)
    np.testing.assert_allclose(scan.correlations, 4.0)
    np.testing.assert_array_equal(scan.tilts, 0.0)


def test_tilts_grow_with_the_depth() -> None:
    """A disparity error δ between patches p apart tilts the surface by 2/√3 δ z / (p b)."""
    scan = Scan.from_frame(wall(2.0), settings(0.03))
    noise = DepthNoise()
    expected = (
        np.sqrt(4 / 3)
        * noise.systematic_disparity
        * 2.0
        / (noise.systematic_patch * noise.baseline)
    )
    assert np.sqrt(scan.tilts) == pytest.approx(expected, rel=1e-6)


def test_an_empty_frame_makes_an_empty_scan() -> None:
    blind = np.full((CAMERA.height, CAMERA.width), np.nan, np.float32)
    assert len(Scan.from_frame(RgbdFrame(blind, CAMERA, 0.0))) == 0
