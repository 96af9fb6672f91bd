"""A fit says nothing where one aside of it is as good and the prior decides between both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import THINGS, drive

from circumspect.mapping.ambiguity import is_ambiguous
from circumspect.mapping.motion import Belief
from circumspect.registration import RegistrationSettings, Scan, ScanSurface, SurfaceMap, register
from circumspect.simulation import Surface, block

SETTINGS = RegistrationSettings()
HERE = RigidTransform.identity()
FLAT = (Surface("wall", block((-6.0, -0.2, -3.0), (6.0, 0.2, 3.0))),)
"""Looks the same wherever one stands along it."""
ALONG = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
FEIGNED = 1.1 / SETTINGS.max_distance
"""What a scene seems to hold the direction along a wall by, though it does not [1/m]."""


def asked(things, sigma, feigned=0.0):
    """Whether a frame before the map of its place, so well expected, is ambiguous."""
    before, now = (
        Scan.from_frame(frame) for frame in drive(np.radians([90.0, 90.0]), things=things)
    )
    scene = SurfaceMap()
    for metres in (-0.4, 0.4, 0.0) if things is FLAT else (0.0,):
        aside = RigidTransform.from_translation([metres, 0.0, 0.0])
        scene = scene.with_surface(ScanSurface.from_scan(before), aside)
    expected = Belief(HERE, np.eye(6) * sigma**2)
    found = register(now, scene, HERE, np.eye(6) / sigma**2, SETTINGS)
    found = replace(found, hessian=found.hessian + np.diag(ALONG) * feigned**2)
    return is_ambiguous(now, scene, found, expected, SETTINGS)


@pytest.mark.parametrize("sigma", [1.1 * SETTINGS.max_distance, 0.5, 2.0])
def test_a_flat_wall_that_seems_to_hold_a_camera_is(sigma):
    assert asked(FLAT, sigma, FEIGNED)


def test_a_flat_wall_that_is_known_not_to_is_left_to_the_prior():
    assert not asked(FLAT, 0.5)


def test_a_camera_that_was_known_well_enough_is_not():
    assert not asked(FLAT, 0.9 * SETTINGS.max_distance, FEIGNED)


@pytest.mark.parametrize("feigned", [0.0, FEIGNED])
def test_a_scene_with_things_in_it_is_not(feigned):
    assert not asked(THINGS, 2.0, feigned)
