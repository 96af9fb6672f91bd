"""The status of the node, and the throttle of its log."""

from __future__ import annotations

import logging
from contextlib import suppress
from types import SimpleNamespace
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.errors import InputError
from circumspect.recognition import FrameOutcome
from circumspect.recording.ros_types import CAMERA_INFO, IMAGE, ODOMETRY, TRANSFORMS
from circumspect.ros.health import ERROR, OK, WARNING, Health
from circumspect.ros.log_throttle import LogThrottle
from circumspect.ros.wire_messages import deserialized
from circumspect.tracking import PoseEstimate, TrackingState


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def step(
    outcome: str = FrameOutcome.CLASSIFIED,
    known: bool = True,
    pose: Any = None,
    coverage: float = 0.75,
    warning: str = "",
) -> Any:
    shares = {"chair": 0.94, "sofa": 0.06}
    prediction = Prediction("chair", 0.94, shares, in_distribution=known, coverage=coverage)
    return SimpleNamespace(
        outcome=outcome, prediction=prediction, pose=pose, odometry_warning=warning
    )


def test_the_status_shows_the_most_severe_fault() -> None:
    clock = Clock()
    health = Health(clock)
    assert health.status(True, "no depth", 0).level == ERROR
    assert health.status(False, "no depth", 0).level == OK
    assert health.status(True, None, 0).text == "waiting for the first frame"
    health.report_error("wrong encoding")
    assert health.status(True, None, 0).level == ERROR
    health.on_step(step(), 20.0)
    assert health.status(True, None, 0).level == WARNING
    clock.now += 6
    assert "recently" in health.status(True, None, 0).text
    health.on_step(step(FrameOutcome.NO_OBJECT), 20.0)
    assert health.status(True, None, 0).text == FrameOutcome.NO_OBJECT
    health.on_step(step(), 20.0)
    assert health.status(True, None, 0).level == OK
    health.on_step(step(known=False), 20.0)
    status = health.status(True, None, 3)
    assert status.text.endswith("not confident: the object is unlike the trained classes")
    values = status.values
    assert (values["confident"], values["in_distribution"]) == ("no", "no")
    assert values["messages lost in transport"] == 3
    health.on_step(step(coverage=0.74), 20.0)
    status = health.status(True, None, 0)
    assert status.text.endswith("not confident: at least 75 % coverage is needed")
    values = status.values
    assert (values["answer"], values["confident"], values["coverage"]) == ("chair", "no", "0.74")
    assert values["reason"] == "at least 75 % coverage is needed"
    health.on_step(step(), 20.0)
    values = health.status(True, None, 0).values
    assert (values["confident"], values["reason"]) == ("yes", "")
    health.reset()
    assert health.status(True, None, 0).values["answer"] == "none"


def test_the_status_reports_the_uncertainty_of_the_pose() -> None:
    health = Health()
    health.on_step(step(), 20.0)
    assert not any(name.startswith("pose") for name in health.status(True, None, 0).values)
    for millimetres, accurate in ((12, "yes"), (30, "no")):
        covariance = np.diag([0.001, 0.001, 0.002, 0.001, 0.001, 1e-3 * millimetres]) ** 2
        pose = PoseEstimate(RigidTransform.identity(), covariance=covariance)
        health.on_step(step(pose=pose), 20.0)
        values = health.status(True, None, 0).values
        assert (values["pose state"], values["pose accurate"]) == ("tracking", accurate)
        assert values["pose, standard deviation [mm]"] == str(millimetres)
        assert values["pose, standard deviation [°]"] == "0.1"
    health.reset()
    assert "pose accurate" not in health.status(True, None, 0).values


def test_odometry_on_another_clock_is_a_warning() -> None:
    health = Health()
    health.on_step(step(warning="odometry and images are on different clocks"), 20.0)
    status = health.status(True, None, 0)
    assert (status.level, status.text) == (WARNING, "odometry and images are on different clocks")
    health.on_step(step(), 20.0)
    assert health.status(True, None, 0).level == OK


def test_a_pose_that_is_not_reliable_is_a_warning_with_the_reason() -> None:
    health = Health()
    why = "the scans contradict the map"
    pose = PoseEstimate(RigidTransform.identity(), TrackingState.LOST, why, covariance=np.eye(6))
    health.on_step(step(pose=pose, outcome=FrameOutcome.NO_POSE), 20.0)
    status = health.status(True, None, 0)
    assert (status.level, status.text) == (WARNING, f"pose not reliable: {why}")
    assert (status.values["pose state"], status.values["pose accurate"]) == ("lost", "no")


def test_the_number_of_reasons_is_bounded() -> None:
    health = Health()
    for number in range(1000):
        health.report_error(f"reason {number}")
    values = health.status(True, None, 0).values
    assert sum("skipped" in name for name in values) < 30
    assert values["skipped: other reasons"] == 980


def test_a_repeated_log_line_is_throttled() -> None:
    clock = Clock()
    throttle = LogThrottle(5.0, clock)

    def logged(text: str, *words: object) -> str | None:
        record = logging.LogRecord("a", logging.WARNING, "", 0, text, words, None)
        return record.getMessage() if throttle.filter(record) else None

    assert logged("frame %d left out", 1) == "frame 1 left out"
    assert logged("frame %d left out", 2) is None
    assert logged("another") == "another"
    clock.now += 5
    assert logged("frame %d left out", 3) == "frame 3 left out (and 1 more like this)"
    for number in range(1000):
        logged("x" * number)
    assert len(throttle._logged) == 200


def test_faults_of_two_topics_do_not_hide_each_other() -> None:
    throttle = LogThrottle(5.0, Clock())

    def logged(topic: str, stamp: float) -> bool:
        words = (topic, f"the message at {stamp:.3f} s is broken")
        record = logging.LogRecord("a", logging.WARNING, "", 0, "%s: %s", words, None)
        return throttle.filter(record)

    assert logged("/depth", 1.0)
    assert logged("/odom", 1.1)
    assert not logged("/depth", 1.2)


@given(st.binary(max_size=300), st.sampled_from([IMAGE, CAMERA_INFO, ODOMETRY, TRANSFORMS]))
def test_any_bytes_are_a_message_or_an_input_error(data: bytes, kind: str) -> None:
    for serialized in (data, b"\0\1\0\0" + data, b"\0\0\0\0" + data):
        with suppress(InputError):
            assert deserialized(kind, serialized).__msgtype__ == kind
