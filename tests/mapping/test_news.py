"""What is new, and what is out of place."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform
from tracking_world import SHORT, blind, short_drive, true_camera

from circumspect.mapping import RegisteredPoses
from circumspect.mapping.news import is_out_of_place, rest_is_news
from circumspect.registration import Scan, register
from circumspect.sensing import RgbdFrame

TIGHT = np.diag([1e8] * 6)


def verdict(shift: list[float]) -> bool:
    """Of the last frame, held to a place that is wrong by a shift [m] in the optical frame."""
    first, last = short_drive()[0], short_drive()[-1]
    poses = RegisteredPoses()
    poses.estimate(first)
    T_map_true = poses.keyframes.places[0] * true_camera(float(SHORT[0])).inv()
    believed = T_map_true * true_camera(float(SHORT[-1])) * RigidTransform.from_translation(shift)
    scan = Scan.from_frame(last)
    found = register(scan, poses.scene, believed, TIGHT)
    return rest_is_news(scan, found, poses.scene, poses.keyframes, 0.05)


def test_what_comes_into_view_round_a_corner_is_news() -> None:
    assert verdict([0.0, 0.0, 0.0])


def test_things_where_there_was_nothing_are_none() -> None:
    assert not verdict([0.0, 0.0, -0.4])
    assert not verdict([0.35, 0.0, -0.3])


def test_what_is_new_or_nothing_is_not_out_of_place() -> None:
    first = short_drive()[0]
    poses = RegisteredPoses()
    T = poses.estimate(first).T_map_camera

    def out_of_place(frame: RgbdFrame, nearer: float) -> bool:
        place = T * RigidTransform.from_translation([0.0, 0.0, -nearer])
        return is_out_of_place(Scan.from_frame(frame), place, poses.scene, poses.keyframes, 0.05)

    assert not out_of_place(first, 0.0), "it is where it should be"
    assert not out_of_place(blind(first), 0.0), "it shows nothing"
    assert not out_of_place(first, 20.0), "nobody looked there so far"
    assert out_of_place(first, 0.4), "where it shows things was nothing"
