"""When a camera that was out of sight, or leapt, is built on again."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.mapping.attempt import Attempt
from circumspect.mapping.gate import Verdict
from circumspect.mapping.motion import Belief
from circumspect.mapping.probation import Probation
from circumspect.registration import Registration

FRAMES, LEAP = 3, 0.025
MUTE, CONTRADICTS = Verdict("nothing", mute=True), Verdict("other things", contradicts=True)


def attempt(innovation=(0.0,) * 6, verdict=None, distance=0.001, overlap=1.0):
    found = Registration(
        RigidTransform.identity(), np.eye(6), np.eye(6), np.array(innovation),
        1000, 1000, overlap, distance, 0.001, 1.0, 4, converged=True,
    )  # fmt: skip
    return Attempt(Belief(found.T_map_camera, np.eye(6)), verdict or Verdict(), "odometry", found)


def left(*heard):
    """Frames that must still agree after some: (attempt, whether the camera was known)."""
    probation, counts = Probation(FRAMES, LEAP), []
    for each, known in heard:
        probation.hear(each, known)
        counts.append(probation.left)
    return counts


def test_a_camera_that_goes_on_as_expected_is_built_on():
    assert left(*[(attempt(), True)] * 3) == [0, 0, 0]


def test_one_that_was_not_known_is_built_on_once_frames_agree():
    assert left((attempt(), False), *[(attempt(), True)] * 3) == [2, 1, 0, 0]


def test_what_says_nothing_and_what_contradicts_does_not_count():
    between = [(attempt(verdict=MUTE), True), (attempt(verdict=CONTRADICTS), True)]
    assert left((attempt(), False), *between, (attempt(), True)) == [2, 2, 2, 1]
    assert left(*[(attempt(verdict=MUTE), False)] * 2, (attempt(), False)) == [3, 3, 2]


STEADY = [(attempt(), True)] * 20


def test_what_agrees_in_some_directions_counts():
    agrees = attempt(verdict=Verdict("the scene leaves one direction free"))
    assert left((attempt(), False), (agrees, True), (agrees, True)) == [2, 1, 0]


@pytest.mark.parametrize("axis", range(6))
def test_after_a_leap_another_frame_must_agree(axis):
    innovation = np.zeros(6)
    innovation[axis] = -1.1 * LEAP
    leapt = attempt(innovation)
    assert left(*STEADY, (leapt, True), (attempt(), True))[-2:] == [1, 0]
    assert left(*STEADY, (attempt(), False), (leapt, True), (leapt, True))[-3:] == [2, 1, 1]
    assert left(*STEADY, (attempt(0.9 * innovation / 1.1), True))[-1] == 0


def test_after_a_frame_that_lies_on_the_map_as_none_did_another_must_agree():
    odd, as_usual = attempt(distance=0.0035), attempt(distance=0.0025)
    assert left(*STEADY, (odd, True), (attempt(), True))[-2:] == [1, 0]
    assert left(*STEADY, (as_usual, True))[-1] == 0
    # Three of them do not make it usual, and what is new in a frame adds to its distance.
    far = attempt(distance=0.007)
    assert left(*STEADY, *[(far, True)] * 3)[-3:] == [1, 1, 1]
    assert left(*STEADY, (attempt(distance=0.007, overlap=0.9), True))[-1] == 0


def test_a_wall_further_off_becomes_usual():
    far = [(attempt(distance=0.02), True)] * 30
    assert left(*STEADY, *far)[-9:] == [0] * 9


def test_leaps_to_and_fro_do_not_become_usual_at_once():
    leapt = attempt([0, 0, 0, 1.1 * LEAP, 0, 0])
    assert left(*STEADY, *[(leapt, True)] * 4)[-4:] == [1] * 4


@pytest.mark.parametrize("before", [[], STEADY])
def test_a_camera_that_leaps_all_the_time_is_built_on(before):
    leaps = [(attempt([0, 0, 0, 2 * LEAP, 0, 0]), True)] * 25
    assert left(*before, *leaps)[-9:] == [0] * 9
