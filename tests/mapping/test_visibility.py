from __future__ import annotations

from dataclasses import replace

import numpy as np
from tracking_world import CAMERA, T_BASE_CAMERA, short_drive

from circumspect.mapping.scan import Scan, ScanSettings
from circumspect.mapping.scan_surface import ScanSurface
from circumspect.mapping.scene_map import SceneMap
from circumspect.mapping.visibility import phantoms_of, seen_through
from circumspect.sensing import RgbdFrame

SHAPE = CAMERA.height, CAMERA.width


def showing(depth: np.ndarray) -> RgbdFrame:
    return replace(short_drive()[0], depth=depth)


def mapped(*depths: np.ndarray) -> SceneMap:
    """What some depth images show, all taken from one place."""
    scene = SceneMap(0.03)
    for depth in depths:
        scan = Scan.of(showing(depth), ScanSettings())
        scene = scene.with_surface(ScanSurface.of(scan), T_BASE_CAMERA)
    return scene


def board(left: int, right: int) -> np.ndarray:
    """A board 1 m away before a wall, between two columns of the picture."""
    depth = np.full(SHAPE, 2.4)
    depth[20:120, left:right] = 1.0
    return depth


def test_a_surface_that_is_not_there_is_seen_through_up_to_its_rim() -> None:
    scene, wall = mapped(board(60, 180)), np.full(SHAPE, 2.4)
    assert seen_through(showing(board(60, 180)), scene, T_BASE_CAMERA) == 0
    assert seen_through(showing(wall), scene, T_BASE_CAMERA) > 0.15
    half = seen_through(showing(board(120, 180)), scene, T_BASE_CAMERA)
    assert 0.05 < half < 0.5 * seen_through(showing(wall), scene, T_BASE_CAMERA)
    assert seen_through(showing(wall), SceneMap(0.03), T_BASE_CAMERA) == 0


def test_what_a_keyframe_looked_through_speaks_against_no_frame() -> None:
    """Half of the board is a phantom: it was in the map, and a keyframe does not show it."""
    scene = mapped(board(60, 180))
    half = showing(board(120, 180))
    phantoms = phantoms_of(half, scene, T_BASE_CAMERA)
    assert len(phantoms) > 20
    assert (np.diff(phantoms) > 0).all()
    assert np.isin(phantoms, scene.sums.keys).all()
    assert seen_through(half, scene, T_BASE_CAMERA) > 0.05
    assert seen_through(half, scene, T_BASE_CAMERA, phantoms) == 0
    # The other half speaks as before.
    assert seen_through(showing(board(60, 120)), scene, T_BASE_CAMERA, phantoms) > 0.05
    assert len(phantoms_of(showing(board(60, 180)), scene, T_BASE_CAMERA)) == 0
