from __future__ import annotations

import math

import numpy as np
import pytest
from grid_cases import seeds
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.grid import (
    AZIMUTH_AXIS,
    CylindricalGrid,
    RectangularGrid,
    angular_spectrum,
    rotate_spectrum,
    spectrum_orders,
)


def cells(seed, sectors):
    return np.random.default_rng(seed).random((3, sectors, 2))


@given(seeds, st.integers(1, 40), st.integers(-80, 80))
def test_a_turn_by_whole_cells_moves_the_phase(seed, sectors, k):
    values = cells(seed, sectors)
    turned = angular_spectrum(np.roll(values, k, axis=AZIMUTH_AXIS))
    expected = rotate_spectrum(angular_spectrum(values), k * math.tau / sectors)
    np.testing.assert_allclose(turned, expected, atol=1e-12)
    np.testing.assert_allclose(np.abs(turned), np.abs(angular_spectrum(values)), atol=1e-12)


@given(seeds, st.integers(3, 40), st.floats(-7, 7))
def test_a_turn_by_any_angle_moves_the_phase_of_a_wave(seed, sectors, alpha):
    m = 1 + seed % ((sectors - 1) // 2)
    theta = math.tau * np.arange(sectors) / sectors
    wave = np.exp(1j * m * theta)[None, :, None]
    turned = np.exp(1j * m * (theta - alpha))[None, :, None]
    expected = angular_spectrum(turned, [m])
    np.testing.assert_allclose(
        rotate_spectrum(angular_spectrum(wave, [m]), alpha, [m]), expected, atol=1e-10
    )


@given(seeds, st.integers(1, 40))
def test_energy_is_preserved(seed, sectors):
    values = cells(seed, sectors)
    energy = (np.abs(angular_spectrum(values)) ** 2).sum(axis=AZIMUTH_AXIS)
    np.testing.assert_allclose(energy, (values**2).mean(axis=AZIMUTH_AXIS), atol=1e-12)


@given(seeds, st.integers(1, 30))
def test_the_coefficients_are_those_of_equation_1(seed, sectors):
    values = cells(seed, sectors)
    theta = math.tau * np.arange(sectors) / sectors
    orders = spectrum_orders(sectors)
    basis = np.exp(1j * orders[:, None] * theta)
    sums = np.einsum("rmh,mj->rjh", angular_spectrum(values), basis)
    np.testing.assert_allclose(sums, values, atol=1e-12)


def test_chosen_orders_of_many_grids():
    values = np.random.default_rng(0).random((4, 5, 3, 16, 2))
    some = angular_spectrum(values, [0, -1, 3])
    assert some.shape == (4, 5, 3, 3, 2)
    everything = angular_spectrum(values)
    order = list(spectrum_orders(16))
    for at, m in enumerate((0, -1, 3)):
        np.testing.assert_array_equal(some[:, :, :, at], everything[:, :, :, order.index(m)])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: angular_spectrum(np.zeros((3, 4))), "values must have shape"),
        (lambda: angular_spectrum(np.zeros((3, 0, 4))), "no azimuth cells"),
        (lambda: angular_spectrum(np.zeros((3, 4, 4)), [0.5]), "whole numbers"),
        (lambda: rotate_spectrum(np.zeros((3, 4)), 1.0), "coefficients must have shape"),
        (lambda: rotate_spectrum(np.zeros((3, 4, 2)), 1.0, [1]), "1 orders for 4"),
    ],
)
def test_wrong_shapes_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_only_occupied_cells_of_a_grid_count():
    points = np.random.default_rng(0).uniform(-1, 1, (200, 3))
    grid = CylindricalGrid((4, 8, 4), 2.0).hits(points)
    np.testing.assert_array_equal(angular_spectrum(grid), angular_spectrum(grid.occupied))
    with pytest.raises(InputError, match="cylindrical"):
        angular_spectrum(RectangularGrid((4, 4, 4), 2.0).hits(points))
