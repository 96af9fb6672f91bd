from __future__ import annotations

import numpy as np
from tracking_world import SHORT, short_drive, true_camera

from circumspect.mapping.compact_surface import CompactSurface
from circumspect.mapping.scan import Scan
from circumspect.mapping.scan_surface import ScanSurface
from circumspect.mapping.scene_map import SceneMap


def test_a_compact_surface_takes_half_the_memory_and_makes_the_same_map() -> None:
    surface = ScanSurface.of(Scan.of(short_drive()[0]))
    compact = CompactSurface.of(surface)
    assert compact.points_xyz.nbytes == surface.scan.points_xyz.nbytes / 2
    pose = true_camera(float(SHORT[0]))
    one, other = (SceneMap().with_surface(s, pose) for s in (surface, compact.expanded()))
    # A point at the very side of a voxel may come to lie in the next one.
    assert abs(len(one) - len(other)) <= 2
    _, gaps = one.nearest(other.points_xyz)
    assert np.quantile(gaps, 0.99) < 1e-6
