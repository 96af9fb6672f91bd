"""Small frames and bags to record and read back."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.recording import RunRecorder
from circumspect.sensing import Odometry, RgbdFrame
from circumspect.sensing.millimetres import metres
from circumspect.sensing.viewing import looking

CAMERA = PinholeCamera(32, 24, 30.0, 31.0, 15.3, 11.7)
MOUNT = looking([0.1, 0.2, 1.1], 1.5, 0.4)


def frame(number: int, interval: float = 0.1, colour: bool = False) -> RgbdFrame:
    """A frame of a robot that drives; no two are alike."""
    rng = np.random.default_rng(number)
    depth = metres(rng.integers(0, 5000, (24, 32)).astype(np.uint16))
    stamp = number * interval
    half = rng.normal(size=(3, 3))
    odometry = Odometry(
        stamp, PlanarPose(0.02 * number, -0.01 * number, 0.03 * number), half @ half.T, 0.05, 0.3
    )
    picture = rng.integers(0, 256, (24, 32, 3)).astype(np.uint8) if colour else None
    return RgbdFrame(depth, CAMERA, stamp, None, picture, odometry, MOUNT)


def frames(count: int, interval: float = 0.1) -> list[RgbdFrame]:
    return [frame(number, interval) for number in range(count)]


def recorded(path: Path, taken: Iterable[RgbdFrame]) -> list[RgbdFrame]:
    """Record frames; returns those that the recorder passes on."""
    recorder = RunRecorder(path, {"config": "{}"})
    handed_on = [recorder.frame(one) for one in taken]
    recorder.close()
    assert recorder.failure is None
    return handed_on


def same(one: RgbdFrame, other: RgbdFrame) -> None:
    """Assert that two frames are equal bit for bit."""
    np.testing.assert_array_equal(one.depth, other.depth)
    assert one.stamp == other.stamp
    assert one.camera == other.camera
    assert (one.colour is None) == (other.colour is None)
    if one.colour is not None:
        np.testing.assert_array_equal(one.colour, other.colour)
    for a, b in ((one.T_base_camera, other.T_base_camera),):
        assert_same_pose(a, b)
    assert (one.odometry is None) == (other.odometry is None)
    if one.odometry is not None and other.odometry is not None:
        for name in ("stamp", "T_odom_base", "forward", "turn"):
            assert getattr(one.odometry, name) == getattr(other.odometry, name)
        np.testing.assert_array_equal(one.odometry.covariance, other.odometry.covariance)


def assert_same_pose(one: RigidTransform | None, other: RigidTransform | None) -> None:
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        np.testing.assert_array_equal(one.as_matrix(), other.as_matrix())


def without_odometry(one: RgbdFrame) -> RgbdFrame:
    return replace(one, odometry=None)
