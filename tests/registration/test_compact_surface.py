from __future__ import annotations

import numpy as np
from tracking_world import SHORT, short_drive, true_camera

from circumspect.registration import CompactSurface, Scan, ScanSurface, SurfaceMap


def test_compact_surface_takes_half_the_memory_and_makes_the_same_map() -> None:
    surface = ScanSurface.from_scan(Scan.from_frame(short_drive()[0]))
    compact = CompactSurface.from_surface(surface)
    assert compact.points_xyz.nbytes == surface.scan.points_xyz.nbytes / 2
    pose = true_camera(float(SHORT[0]))
    one, other = (SurfaceMap().with_surface(s, pose) for s in (surface, compact.expanded()))
    # Rounding may move a point across the side of a voxel.
    assert abs(len(one) - len(other)) <= 2
    _, gaps = one.nearest(other.points_xyz)
    assert np.quantile(gaps, 0.99) < 1e-6
