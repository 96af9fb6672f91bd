"""The floor reveals wrong poses of a camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PinholeCamera
from circumspect.sensing import (
    BoxSegmentation,
    DepthNoise,
    FloorProblem,
    GroundSegmentation,
    RgbdFrame,
)
from circumspect.simulation import Orbit, Scene, SimulatedCamera

CAMERA = PinholeCamera.xtion()


def frame_of(category: str, camera: PinholeCamera = CAMERA) -> RgbdFrame:
    mesh = make_furniture(category, 5)
    stations = Orbit.around(mesh, camera, start=0.4).stations(1)
    scene = Scene.with_object(mesh)
    return SimulatedCamera(scene, stations.__next__, camera, DepthNoise()).capture()


def mistaken(frame: RgbdFrame, higher: float, lower_tilt: float) -> RgbdFrame:
    """The frame with a pose that is too high [m] and looks too far down [degrees]."""
    turn = Rotation.from_euler("x", -lower_tilt, degrees=True)
    place = np.add(frame.pose.translation, [0, 0, higher])
    pose = RigidTransform.from_components(place, frame.pose.rotation * turn)
    return replace(frame, T_map_camera=pose)


@pytest.mark.parametrize("category", CATEGORIES)
def test_a_true_pose_gives_no_problem(category: str) -> None:
    assert GroundSegmentation().problem(frame_of(category)) is None


@pytest.mark.parametrize("category", ["chair", "table", "bed"])
@pytest.mark.parametrize(
    ("higher", "lower_tilt", "problem"),
    [
        (0.3, 0, FloorProblem.NO_FLOOR),
        (-0.3, 0, FloorProblem.BELOW_FLOOR),
        (0, 5, FloorProblem.BELOW_FLOOR),
        (0, -5, FloorProblem.NO_FLOOR),
    ],
)
def test_a_wrong_height_or_tilt_is_found(
    category: str, higher: float, lower_tilt: float, problem: str
) -> None:
    wrong = mistaken(frame_of(category), higher, lower_tilt)
    assert GroundSegmentation().problem(wrong) == problem


@pytest.mark.parametrize(
    ("higher", "problem"),
    [(0, None), (0.3, FloorProblem.NO_FLOOR), (-0.3, FloorProblem.BELOW_FLOOR)],
)
def test_small_images_give_the_same_result(higher: float, problem: str | None) -> None:
    camera = PinholeCamera(160, 120, 142.5, 142.5, 79.5, 59.5)
    frame = mistaken(frame_of("bed", camera), higher, 0)
    assert GroundSegmentation().problem(frame) == problem


def test_few_points_give_no_problem() -> None:
    frame = frame_of("chair")
    depth = np.where(np.arange(frame.depth.size).reshape(frame.depth.shape) % 997, np.nan, 1.0)
    assert GroundSegmentation().problem(replace(frame, depth=depth)) is None


def test_a_box_needs_no_floor() -> None:
    wrong = mistaken(frame_of("chair"), 0.3, 0)
    assert BoxSegmentation((-1, -1, 0), (1, 1, 2)).problem(wrong) is None
