"""Centre and reach of a cloud: the native kernels against NumPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from grid_cases import seeds
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import GeometryError
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, RectangularGrid, _native
from circumspect.grid.bounds_fit import reach_of


@given(
    st.one_of(st.integers(1, 300), st.integers(1000, 3000)),
    st.sampled_from([1e-6, 1.0, 1e6]),
    st.sampled_from([0.0, 1.0, 1e6]),
    st.booleans(),
    st.floats(-7, 7),
    seeds,
)
def test_centre_and_reach_equal_those_of_numpy(count, unit, offset, weighted, yaw, seed):
    rng = np.random.default_rng(seed)
    points = unit * (rng.normal(size=(count, 3)) + offset)
    areas = rng.random(count) if weighted else None
    found = reach_of(PointCloud(points, areas), yaw)
    tolerance = 1e-13 * unit * (1 + offset)
    np.testing.assert_allclose(
        found.centre_xyz, np.average(points, axis=0, weights=areas), atol=tolerance
    )
    x, y, z = (points - found.centre_xyz).T
    cosine, sine = math.cos(yaw), math.sin(yaw)
    along = np.abs([cosine * x + sine * y, cosine * y - sine * x, z]).max(axis=1)
    assert found.radius == np.sqrt(x * x + y * y).max()
    assert found.along_xyz == tuple(along)
    assert found.largest == np.abs(points).max()


@given(st.integers(2, 600), st.sampled_from([1e-6, 1.0, 1e6]), seeds)
def test_fitted_grids_hold_all_points(count, unit, seed):
    points = unit * np.random.default_rng(seed).normal(size=(count, 3))
    for grid in (CylindricalGrid.fit(points), RectangularGrid.fit(points, yaw=0.4)):
        assert (grid.indices(points) >= 0).all()


def test_points_without_area_count_alike():
    points = np.random.default_rng(0).normal(size=(100, 3))
    alike, none = reach_of(PointCloud(points)), reach_of(PointCloud(points, np.zeros(100)))
    assert alike == none


def test_the_centre_is_within_the_points_despite_rounding():
    points = np.full((1000, 3), 0.1)
    points[:, 0] = 1 / 3
    assert reach_of(PointCloud(points)).centre_xyz == (1 / 3, 0.1, 0.1)
    with pytest.raises(GeometryError, match="all 1000 points lie in one place"):
        CylindricalGrid.fit(points)


def test_points_too_far_out_are_refused():
    with pytest.raises(GeometryError, match="beyond 1e49 m"):
        reach_of(PointCloud(np.array([[0, 0, 0], [0, -1e99, 0]])))


def test_the_kernels_refuse_sizes_that_do_not_fit():
    with pytest.raises(ValueError, match="a point"):
        _native.weighted_centre(np.zeros((0, 3)), None)
    with pytest.raises(ValueError, match="as many weights"):
        _native.weighted_centre(np.zeros((3, 3)), np.ones(2))
    with pytest.raises(TypeError):
        _native.weighted_centre(np.zeros((3, 2)), None)
    assert _native.reach(np.zeros((0, 3)), (0.0, 0.0, 0.0), 0.0) == (0.0, 0.0, 0.0, 0.0)
