"""Cameras, tags and corners for the tests of the intelligent space."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.localization import FixedCamera, LensCamera, Sighting, TagMount, TagPose

BEND = (-0.20, 0.045, 3e-4, -4e-4, -0.004)
MOUNT = TagMount(3, 0.20, 0.30, PlanarPose(0.05, -0.02, 0.4))


def lens(focal=900.0, bend=BEND, size=(1280, 960)):
    w, h = size
    return LensCamera(PinholeCamera(w, h, focal, 1.001 * focal, w / 2 + 3.0, h / 2 - 5.0), bend)


def camera(x=0.0, y=0.0, name="c", tilt=(3.0, -4.0), heading=30.0, covariance=None, **lens_options):
    turn = Rotation.from_euler("z", heading, degrees=True) * Rotation.from_euler("x", np.pi)
    turn = turn * Rotation.from_euler("xy", tilt, degrees=True)
    pose = RigidTransform.from_components([x, y, 3.0], turn)
    return FixedCamera(
        name, lens(**lens_options), pose, np.zeros((6, 6)) if covariance is None else covariance
    )


def corners(of, pose, mount=MOUNT):
    """(4, 2) [px] where a camera sees the corners of a robot's tag."""
    own = pose.applied(mount.corners_xy)
    return of.project(np.column_stack([own, np.full(4, mount.height)]))


def sighted(name, stamp, x, y, yaw=0.0, sigma=0.001):
    """The sighting of a camera that sees the robot there."""
    noise = sigma**2 * np.eye(3)
    return Sighting(name, stamp, TagPose(PlanarPose(x, y, yaw), noise, 0.1 * noise, 5.0))


def unlike(pose, other):
    """(3,) x, y [m] and yaw [rad] between two poses."""
    turn = (pose.yaw - other.yaw + np.pi) % (2 * np.pi) - np.pi
    return np.array([pose.x - other.x, pose.y - other.y, turn])
