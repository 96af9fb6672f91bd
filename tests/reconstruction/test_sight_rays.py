from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.reconstruction import SightRays
from circumspect.reconstruction.sight_rays import END_CELL_M, ORIGIN_CELL_M


@given(seed=st.integers(0, 2**32 - 1), frames=st.integers(1, 4))
def test_one_given_ray_is_kept_per_pair_of_cells(seed: int, frames: int) -> None:
    rng = np.random.default_rng(seed)
    rays, expected, given_rays = SightRays.empty(), set(), set()
    for _ in range(frames):
        origin = rng.uniform(-1, 1, 3).astype(np.float32)
        ends = rng.uniform(-0.1, 0.1, (50, 3)).astype(np.float32)
        on_object = rng.random(50) < 0.5
        rays = rays.with_frame(origin, ends, on_object)
        for end, hit in zip(ends, on_object, strict=True):
            cells = (*np.floor(end / END_CELL_M), *np.floor(origin / ORIGIN_CELL_M), bool(hit))
            expected.add(tuple(map(int, cells)))
            given_rays.add((*origin.tolist(), *end.tolist(), bool(hit)))
    assert len(rays) == len(expected)
    assert (rays.keys[1:] > rays.keys[:-1]).all()
    kept = np.column_stack([rays.origins_xyz, rays.ends_xyz]).tolist()
    assert {(*row, bool(hit)) for row, hit in zip(kept, rays.on_object, strict=True)} <= given_rays
