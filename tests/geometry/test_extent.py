"""Points that span no shape, at any scale and place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from circumspect.errors import GeometryError
from circumspect.geometry import _native, read_cloud, require_extent


def cloud_of(points: object, folder: Path) -> object:
    np.save(folder / "a.npy", np.asarray(points, dtype=float))
    return read_cloud(folder / "a.npy")


LINE = np.linspace(0, 1, 100)[:, None] * [1.0, 2.0, 3.0]


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("offset", [0.0, 1.0, 1e3])
@pytest.mark.parametrize(
    ("points", "word"),
    [
        (np.zeros((1, 3)), "single point"),
        (np.zeros((5, 3)), "all 5 points lie in one place"),
        (np.tile([0.1, 0.7, 1 / 3], (1000, 1)), "all 1000 points lie in one place"),
        (LINE, "all 100 points lie on a line"),
        (np.eye(3)[:2], "all 2 points lie on a line"),
    ],
)
def test_points_without_extent(points, word: str, offset: float, scale: float, tmp_path: Path):
    with pytest.raises(GeometryError, match=word):
        require_extent(cloud_of((points + offset) * scale, tmp_path))


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("offset", [0.0, 1.0, 1e6])
def test_a_plane_has_an_extent(scale: float, offset: float, tmp_path: Path):
    plane = np.random.default_rng(0).random((100, 3)) * [1, 1, 0]
    require_extent(cloud_of((plane + offset) * scale, tmp_path))
    require_extent(
        cloud_of((LINE + [[0, 0.001 * (i % 2), 0] for i in range(100)] + offset) * scale, tmp_path)
    )


@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("count", [1, 2, 1000])
def test_the_kernel_agrees_with_numpy(count: int, offset: float):
    points = np.random.default_rng(count).normal(size=(count, 3)) * [1, 2, 0.3] + offset
    low, high, scatter = _native.extent(points)
    np.testing.assert_array_equal(low, points.min(axis=0))
    np.testing.assert_array_equal(high, points.max(axis=0))
    about = points - points.mean(axis=0)
    expected = about.T @ about / (float(np.ptp(points, axis=0).max()) or 1.0) ** 2
    np.testing.assert_allclose(scatter, expected, atol=1e-6)
    with pytest.raises(ValueError, match="a point"):
        _native.extent(np.zeros((0, 3)))
