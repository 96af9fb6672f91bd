from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.exploration.obstacle_map import MIN_FRAMES, OBJECT_MARGIN_M, ObstacleMap
from circumspect.planning.plan_view import cell_keys


@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.integers(0, 60))
def test_points_near_the_object_are_no_obstacles(seed: int, obstacles: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    keys = np.unique(cell_keys(rng.uniform(-1, 1, (obstacles, 2)), 0.05))
    standing = ObstacleMap(keys, rng.integers(1, 4, len(keys)))
    object_xy = rng.uniform(-0.5, 0.5, (count, 2))
    everywhere = standing.places_xy(np.empty((0, 2)))
    assert len(everywhere) == (standing.frames >= MIN_FRAMES).sum()
    away = np.linalg.norm(everywhere[:, None] - object_xy[None], axis=2)
    kept = everywhere[(away > OBJECT_MARGIN_M).all(axis=1)]
    np.testing.assert_array_equal(standing.places_xy(object_xy), kept)
