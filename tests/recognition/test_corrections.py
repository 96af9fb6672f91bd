"""Poses that are corrected later: what becomes of the model and of the steps."""

from __future__ import annotations

from itertools import count

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from small_world import Inline, frames, make_pipeline, run

from circumspect.recognition import (
    RecognitionPipeline,
    RecognitionResult,
    RecognitionStep,
    object_fusion,
    object_grids,
    recognition_pipeline,
    run_pipeline,
)
from circumspect.tracking import PoseEstimate, PoseEstimator

DRIFT = RigidTransform.from_translation([0.1, -0.05, 0.0])
TWO_SUBMAPS = 10_500
"""About the number of voxels in the submaps of two frames."""


class Corrected(PoseEstimator):
    """Off by `DRIFT` up to some frame; every frame is a keyframe."""

    def __init__(self, at: int) -> None:
        self.at, self.true = at, []

    @property
    def corrections(self):
        return int(len(self.true) > self.at)

    def track(self, frame):
        self.true.append(frame.pose)
        number = len(self.true) - 1
        return PoseEstimate(
            self.keyframe_pose(number),
            reference=number,
            T_reference_camera=RigidTransform.identity(),
        )

    def keyframe_pose(self, number):
        return self.true[number] if self.corrections else DRIFT * self.true[number]

    def corrected(self, estimates):
        return [self.keyframe_pose(estimate.reference) for estimate in estimates]


class Restless(Corrected):
    """After the correction every frame reports another one, which moves nothing."""

    @property
    def corrections(self):
        return max(0, len(self.true) - self.at)


class CoverageLog:
    """Keeps the coverage at each step."""

    def __init__(self, coverages: list[float]) -> None:
        self.coverages = coverages

    def on_step(self, step: RecognitionStep) -> None:
        self.coverages.append(step.coverage)

    def on_end(self, result: RecognitionResult) -> None:
        pass


def centre(step: RecognitionStep) -> np.ndarray:
    return step.model.cloud().points_xyz.mean(axis=0)


def corrected_pipeline(at: int, poses: type[Corrected] = Corrected) -> RecognitionPipeline:
    parts = make_pipeline()
    return RecognitionPipeline(parts.segmentation, poses(at), parts.classifier)


@pytest.mark.parametrize("poses", [Corrected, Restless])
def test_submaps_are_fused_over_several_frames_after_a_correction(
    poses: type[Corrected], monkeypatch
) -> None:
    """Further corrections do not delay the submap fusion."""
    monkeypatch.setattr(object_fusion, "VOXELS_A_FRAME", TWO_SUBMAPS)
    shots, at = list(frames(12)), 4
    true, pipeline = make_pipeline(), corrected_pipeline(at, poses)
    wanted, steps = ([one.step(shot) for shot in shots] for one in (true, pipeline))
    # Four submaps, two per frame: the third frame after the correction has the new model.
    assert [step.model.frames for step in steps] == list(range(1, 13))
    off = [np.abs(centre(a) - centre(b)).max() for a, b in zip(steps, wanted, strict=True)]
    assert min(off[: at + 2]) > 0.04
    assert max(off[at + 2 :]) < 0.01


def test_background_and_inline_fusion_give_the_same_model(monkeypatch) -> None:
    monkeypatch.setattr(object_fusion, "VOXELS_A_FRAME", TWO_SUBMAPS)
    shots, beside = list(frames(10)), corrected_pipeline(4)
    monkeypatch.setattr(recognition_pipeline, "BackgroundWorker", Inline)
    before = corrected_pipeline(4)
    for shot in shots:
        one, other = beside.step(shot), before.step(shot)
        np.testing.assert_array_equal(one.model.sums.totals, other.model.sums.totals)
        np.testing.assert_array_equal(one.grid.states, other.grid.states)


def test_a_late_correction_is_applied_at_the_end(monkeypatch) -> None:
    monkeypatch.setattr(object_fusion, "VOXELS_A_FRAME", 1)
    shots = list(frames(8))
    wanted, result = run(shots), run_pipeline(corrected_pipeline(7), shots)
    np.testing.assert_allclose(centre(result.last), centre(wanted.last), atol=0.004)
    assert result.last.model.frames == 8


def test_the_final_coverage_is_that_after_the_last_correction(monkeypatch) -> None:
    monkeypatch.setattr(object_fusion, "VOXELS_A_FRAME", 1)
    shares = count(0.1, 0.01)
    monkeypatch.setattr(object_grids, "azimuth_coverage", lambda *_: next(shares))
    pipeline, coverages = corrected_pipeline(3), []
    result = run_pipeline(pipeline, frames(4), (CoverageLog(coverages),))
    assert result.last.coverage == pipeline.coverage > max(coverages)


class Twice(Corrected):
    """Half of `DRIFT` is corrected at one frame, the rest some frames later."""

    def __init__(self, at: int, again: int) -> None:
        super().__init__(at)
        self.again = again

    @property
    def corrections(self):
        return int(len(self.true) > self.at) + int(len(self.true) > self.again)

    def keyframe_pose(self, number):
        left = RigidTransform.from_translation((1 - self.corrections / 2) * DRIFT.translation)
        return left * self.true[number]


@pytest.mark.parametrize("again", [5, 6, 7])
def test_the_final_model_follows_the_last_correction(again: int, monkeypatch) -> None:
    """The submap fusion of the correction before was still in progress."""
    monkeypatch.setattr(object_fusion, "VOXELS_A_FRAME", 1)
    parts, shots = make_pipeline(), list(frames(8))
    pipeline = RecognitionPipeline(parts.segmentation, Twice(4, again), parts.classifier)
    result = run_pipeline(pipeline, shots)
    np.testing.assert_allclose(centre(result.last), centre(run(shots).last), atol=0.004)
    assert result.last.model.frames == 8
    assert not pipeline.finalise()


@pytest.mark.parametrize("at", [2, 5, 7])
def test_steps_of_a_result_have_corrected_poses(at: int) -> None:
    shots = list(frames(8))
    pipeline = corrected_pipeline(at)
    for shots_of_run in (shots[:6], shots[6:]):
        result = run_pipeline(pipeline, shots_of_run)
        if not pipeline.tracker.corrections:
            continue
        for step, shot in zip(result.steps, shots_of_run, strict=True):
            np.testing.assert_allclose(step.pose.T_map_camera.translation, shot.pose.translation)
