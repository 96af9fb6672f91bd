"""A fit that leaps is believed only where it fits, and where staying does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import THINGS, drive

from circumspect.mapping.leap import FAR, is_hasty
from circumspect.mapping.motion import Belief
from circumspect.registration import RegistrationSettings, Scan, ScanSurface, SurfaceMap, register
from circumspect.simulation import Surface, block

SETTINGS = RegistrationSettings()
HERE = RigidTransform.identity()
UNSURE = np.eye(6) * 0.3**2
FLAT = (Surface("wall", block((-6.0, -0.2, -3.0), (6.0, 0.2, 3.0))),)
"""Looks the same wherever one stands along it."""


def fitted(things, expected=HERE):
    """A frame before the map that it made, expected elsewhere."""
    (frame,) = drive(np.radians([90.0]), things=things)
    scan = Scan.from_frame(frame)
    scene = SurfaceMap().with_surface(ScanSurface.from_scan(scan), HERE)
    return scan, scene, register(scan, scene, expected, np.linalg.inv(UNSURE), SETTINGS)


def aside(metres):
    return RigidTransform.from_translation([metres, 0.0, 0.0])


def asked(things, found_at, expected_at, worse=1.0):
    scan, scene, found = fitted(things)
    leapt = replace(found, T_map_camera=aside(found_at), distance=worse * found.distance)
    belief = Belief(aside(expected_at), UNSURE)
    return is_hasty(scan, scene, leapt, belief, 1.5 * found.distance, SETTINGS)


def test_along_a_flat_wall_no_leap_is_believed():
    assert asked(FLAT, 0.3, 0.0)


def test_a_leap_to_where_it_fits_is_believed():
    assert not asked(THINGS, 0.0, 0.3)


def test_a_leap_to_where_the_scene_pulls_even_a_firm_frame_is_believed():
    assert not asked(THINGS, 0.0, 1.2 * FAR * SETTINGS.max_distance)


def test_a_leap_to_where_it_fits_worse_than_others_is_not():
    assert asked(THINGS, 0.0, 0.3, worse=2.0)


@pytest.mark.parametrize("things", [FLAT, THINGS])
def test_a_small_step_is_no_leap(things):
    assert not asked(things, 0.9 * FAR * SETTINGS.max_distance, 0.0, worse=9.0)
