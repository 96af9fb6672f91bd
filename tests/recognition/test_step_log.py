from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation
from small_world import blind, frames, run

from circumspect.geometry import PlanarPose
from circumspect.recognition import RecognitionStep
from circumspect.recognition.runner import StepLog


class StepRecorder:
    """Keeps every step as it was received."""

    def __init__(self) -> None:
        self.steps: list[RecognitionStep] = []

    def on_step(self, step: RecognitionStep) -> None:
        self.steps.append(step)

    def on_end(self, result: object) -> None:
        pass


@pytest.fixture(scope="module")
def recorded() -> list[RecognitionStep]:
    """Steps whose poses have all optional fields, each missing once."""
    recorder, shots = StepRecorder(), list(frames(6))
    shots[2] = blind(shots[2])
    run(shots, recorder)
    rng = np.random.default_rng(3)
    steps = []
    for number, step in enumerate(recorder.steps):
        pose = step.pose
        if pose is not None:
            T = RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
            pose = replace(
                pose,
                T_map_camera=T * pose.T_map_camera,
                T_reference_camera=None if number == 0 else T * T,
                covariance=None if number == 1 else rng.normal(size=(6, 6)),
                T_map_base=PlanarPose(1.0, 2.0, 3.0),
                reference=number,
            )
        steps.append(replace(step, pose=pose))
    return steps


def test_poses_round_trip_bit_for_bit(recorded: list[RecognitionStep]) -> None:
    log = StepLog()
    for step in recorded:
        log.append(step)
    found = log.steps
    assert len(found) == len(recorded)
    assert sum(step.pose is None for step in found) == 1
    for step, before in zip(found, recorded, strict=True):
        if step.pose is None or before.pose is None:
            assert step.pose is before.pose is None
            continue
        for name in ("T_map_camera", "T_reference_camera"):
            one, other = getattr(step.pose, name), getattr(before.pose, name)
            assert (one is None) == (other is None)
            if one is not None:
                np.testing.assert_array_equal(one.as_matrix(), other.as_matrix())
        np.testing.assert_equal(step.pose.covariance, before.pose.covariance)
        assert step.pose.T_map_base == before.pose.T_map_base
        assert step.pose.reference == before.pose.reference
        assert step.prediction is before.prediction
        assert step.milliseconds == before.milliseconds


def test_only_the_latest_step_keeps_its_model(recorded: list[RecognitionStep]) -> None:
    log = StepLog()
    assert log.steps == []
    for count, step in enumerate(recorded, 1):
        log.append(step)
        assert log.steps[-1] is step
        assert [len(one.model.sums) > 0 for one in log.steps[:-1]] == [False] * (count - 1)
        assert all(one.grid is None for one in log.steps[:-1])
