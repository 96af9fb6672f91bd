from __future__ import annotations

import numpy as np
import pytest

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, RectangularGrid, hits_batch

POINTS = np.random.default_rng(0).normal(size=(50, 3))


def test_a_batch_equals_the_grids_of_single_clouds():
    clouds = [POINTS, PointCloud(0.5 * POINTS), (0.2 * POINTS).astype(np.float32)]
    grids = [CylindricalGrid(radius=r) for r in (1.0, 2.0, 3.0)]
    batch = hits_batch(grids, clouds)
    assert batch.shape == (3, 32, 32, 32)
    for states, grid, cloud in zip(batch, grids, clouds, strict=True):
        assert np.array_equal(states.astype(bool), grid.hits(cloud).occupied)


@pytest.mark.parametrize(
    ("grids", "clouds", "message"),
    [
        ([CylindricalGrid()], [POINTS, POINTS], "1 grids for 2 clouds"),
        ([], [], "no grids"),
        ([CylindricalGrid(), RectangularGrid()], [POINTS] * 2, "alike"),
        ([CylindricalGrid(), CylindricalGrid((8, 8, 8))], [POINTS] * 2, "alike"),
        ([CylindricalGrid()], [POINTS[:, :2]], r"cloud 0 must have shape \(n, 3\), not \(50, 2\)"),
    ],
)
def test_batches_that_do_not_fit_together_are_refused(grids, clouds, message):
    with pytest.raises(InputError, match=message):
        hits_batch(grids, clouds)


@pytest.mark.parametrize("threads", [1, 2, 0])
def test_the_first_broken_cloud_is_named(threads):
    broken = POINTS.copy()
    broken[7, 2] = np.nan
    with pytest.raises(GeometryError, match="cloud 1 "):
        hits_batch([CylindricalGrid()] * 4, [POINTS, broken, POINTS, broken], threads)
