from __future__ import annotations

import numpy as np
import pytest

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise
from circumspect.sensing.millimetres import metres, millimetres

CAMERA = PinholeCamera.xtion()
NOISE = DepthNoise()


def measured(z: float, incidence: float, seed: int = 0, noise: DepthNoise = NOISE) -> np.ndarray:
    depth = np.full((480, 640), z, np.float32)
    return noise.applied(depth, np.full_like(depth, incidence), CAMERA, np.random.default_rng(seed))


def test_the_same_seed_gives_the_same_image_and_another_does_not() -> None:
    np.testing.assert_array_equal(measured(1.5, 0.2, seed=3), measured(1.5, 0.2, seed=3))
    assert (measured(1.5, 0.2, seed=3) != measured(1.5, 0.2, seed=4)).any()


@pytest.mark.parametrize("z", [0.9, 1.5, 2.5, 3.2])
def test_spread_of_a_frontal_plane_is_the_papers_figure_and_quantisation(z: float) -> None:
    image = measured(z, 0.0)
    step = z**2 / (8 * 570.3 * 0.075)
    expected = np.hypot(0.0012 + 0.0019 * (z - 0.4) ** 2, step / np.sqrt(12))
    inside = np.isfinite(image)
    assert inside.mean() > 0.99
    assert image[inside].std() == pytest.approx(expected, rel=0.03)
    # Few disparities, each in whole millimetres: the mean may be off by half of one.
    assert image[inside].mean() == pytest.approx(z, abs=0.02 * expected + 5e-4)


def test_axial_noise_grows_at_grazing_angles() -> None:
    sigmas = [
        float(NOISE.axial_sigma(np.float32(1.5), np.float32(np.radians(d))))
        for d in (0, 59, 70, 79)
    ]
    assert sigmas[0] == sigmas[1] < sigmas[2] < sigmas[3]


def test_disparities_are_multiples_of_an_eighth_pixel_up_to_a_millimetre() -> None:
    image = measured(2.0, 0.0)
    depth, scale = image[np.isfinite(image)].astype(np.float64), 8 * 570.3 * 0.075
    np.testing.assert_allclose(depth, scale / np.rint(scale / depth), atol=0.501e-3)
    assert len(np.unique(depth)) < 12, "steps of 12 mm, not of 1"


def test_depth_comes_in_whole_millimetres() -> None:
    image = measured(1.5, 0.2)
    np.testing.assert_array_equal(metres(millimetres(image)), image)


def test_no_depth_beyond_80_degrees() -> None:
    assert np.isnan(measured(1.5, np.radians(80.5))).all()
    assert np.isfinite(measured(1.5, np.radians(70))).all()


@pytest.mark.parametrize("z", [0.5, 0.75, 3.7, 9.0])
def test_no_depth_out_of_range(z: float) -> None:
    assert np.isnan(measured(z, 0.0)).mean() > 0.999


def test_missing_truth_stays_missing() -> None:
    assert np.isnan(measured(np.nan, np.pi / 2)).all()


def test_pixels_are_missing_at_depth_edges_only() -> None:
    depth = np.full((480, 640), 1.0, np.float32)
    depth[:, 320:] = 2.0
    image = NOISE.applied(depth, np.zeros_like(depth), CAMERA, np.random.default_rng(0))
    lost = np.isnan(image)
    assert 0.4 < lost[:, 319:321].mean() < 0.6
    assert not lost[:, :319].any()
    assert not lost[:, 321:].any()


def test_lateral_noise_mixes_both_sides_of_an_edge_within_three_sigma() -> None:
    depth = np.full((480, 640), 1.0, np.float32)
    depth[:, 320:] = 2.0
    image = NOISE.applied(depth, np.zeros_like(depth), CAMERA, np.random.default_rng(0))
    far = image > 1.5
    strayed = far[:, :320].mean(axis=0)[::-1]
    # Chance that a normal draw of 0.8 px, rounded, reaches over the edge.
    assert strayed[0] > 0.05
    assert strayed[4:].max() < 1e-3


@pytest.mark.parametrize("wrong", [(3.5, 0.8), (-0.1, 3.0), (1.0, float("nan"))])
def test_an_invalid_range_is_refused(wrong: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"minimum and the maximum \[m\]"):
        DepthNoise(*wrong)
