"""Free-space violations of map points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from tracking_world import CAMERA, T_BASE_CAMERA, short_drive

from circumspect.registration import (
    Scan,
    ScanSurface,
    SurfaceMap,
    violated_points,
    violation_ratio,
)
from circumspect.sensing import RgbdFrame

SHAPE = CAMERA.height, CAMERA.width


def showing(depth: np.ndarray) -> RgbdFrame:
    return replace(short_drive()[0], depth=depth)


def mapped(*depths: np.ndarray) -> SurfaceMap:
    """The map of some depth images, all from one pose."""
    surface_map = SurfaceMap(0.03)
    for depth in depths:
        surface = ScanSurface.from_scan(Scan.from_frame(showing(depth)))
        surface_map = surface_map.with_surface(surface, T_BASE_CAMERA)
    return surface_map


def board(left: int, right: int) -> np.ndarray:
    """A board at 1 m in front of a wall, between two columns of the image."""
    depth = np.full(SHAPE, 2.4)
    depth[20:120, left:right] = 1.0
    return depth


def test_missing_surface_is_violated_up_to_its_rim() -> None:
    surface_map, wall = mapped(board(60, 180)), showing(np.full(SHAPE, 2.4))
    assert violation_ratio(showing(board(60, 180)), surface_map, T_BASE_CAMERA) == 0
    whole = violation_ratio(wall, surface_map, T_BASE_CAMERA)
    assert whole > 0.15
    half = violation_ratio(showing(board(120, 180)), surface_map, T_BASE_CAMERA)
    assert 0.05 < half < 0.5 * whole
    assert violation_ratio(wall, SurfaceMap(0.03), T_BASE_CAMERA) == 0


def test_ignored_points_do_not_count() -> None:
    """Half of the board is in the map, but not in the frame."""
    surface_map = mapped(board(60, 180))
    half = showing(board(120, 180))
    ignored_keys = violated_points(half, surface_map, T_BASE_CAMERA)
    assert len(ignored_keys) > 20
    assert (np.diff(ignored_keys) > 0).all()
    assert np.isin(ignored_keys, surface_map.sums.keys).all()
    assert violation_ratio(half, surface_map, T_BASE_CAMERA) > 0.05
    assert violation_ratio(half, surface_map, T_BASE_CAMERA, ignored_keys) == 0
    # The other half counts as before.
    other_half = showing(board(60, 120))
    assert violation_ratio(other_half, surface_map, T_BASE_CAMERA, ignored_keys) > 0.05
    assert len(violated_points(showing(board(60, 180)), surface_map, T_BASE_CAMERA)) == 0
