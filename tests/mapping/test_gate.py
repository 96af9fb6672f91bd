"""When a registration is believed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform
from tracking_world import bare_wall, short_drive

from circumspect.geometry import se3
from circumspect.mapping.gate import GateSettings, squared_distance, weakest_direction
from circumspect.registration import Scan, ScanSurface, SurfaceMap, register
from circumspect.sensing import RgbdFrame

LOOSE = np.diag([1e3] * 3 + [1e3] * 3)


def test_free_directions_of_a_floor_close_the_gate() -> None:
    camera = short_drive()[0].camera
    down = RigidTransform.from_matrix(
        [[1, 0, 0, 0.0], [0, -1, 0, 0.0], [0, 0, -1, 1.0], [0, 0, 0, 1.0]]
    )
    scan = Scan.from_frame(RgbdFrame(np.ones((camera.height, camera.width)), camera, 0.0))
    floor = SurfaceMap().with_surface(ScanSurface.from_scan(scan), down)
    off = se3.exp([0.02, 0.0, 0.0, 0.01, 0.02, 0.03])
    found = register(scan, floor, down * off, LOOSE)
    assert weakest_direction(found.hessian) > 10
    assert GateSettings().verdict(found, LOOSE).reason == "the scene leaves one direction free"
    firmer = replace(found, hessian=np.diag([1e6] * 5 + [0.05**-2]))
    reason = GateSettings().verdict(firmer, LOOSE).reason
    assert reason == "the scene holds one direction to 0.050 m; 0.03 m are needed"
    assert np.isfinite(squared_distance(found, LOOSE))


def test_bare_wall_closes_the_gate() -> None:
    rng = np.random.default_rng(0)
    surface = ScanSurface.from_scan(bare_wall(rng))
    wall = SurfaceMap().with_surface(surface, RigidTransform.identity())
    prior = RigidTransform.from_translation([0.02, -0.01, 0.01])
    information = np.diag(np.array([np.radians(1.0)] * 3 + [0.02] * 3) ** -2.0)
    found = register(bare_wall(rng), wall, prior, information)
    assert not GateSettings().verdict(found, information).is_open
