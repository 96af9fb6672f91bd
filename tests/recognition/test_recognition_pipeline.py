from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.spatial.transform import RigidTransform, Rotation
from small_world import StepRecorder, blind, frames, make_pipeline, run
from volume_classifier import VolumeClassifier

from circumspect.classification import GridSpec, Prediction
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.errors import InputError, WeightsError
from circumspect.grid import OccupancyGrid
from circumspect.recognition import (
    FrameOutcome,
    RecognitionPipeline,
    RecognitionResult,
    run_pipeline,
)
from circumspect.reconstruction import object_model
from circumspect.runs import RunPath
from circumspect.runs.panels import draw_probabilities
from circumspect.sensing import GroundSegmentation, RgbdFrame, Segmentation
from circumspect.tracking import KnownPoses, PoseEstimate, PoseEstimator


def test_every_frame_gives_a_step_and_an_answer() -> None:
    recorder = StepRecorder()
    result = run(frames(5), recorder)
    assert [step.index for step in result.steps] == [0, 1, 2, 3, 4]
    assert {step.outcome for step in result.steps} == {FrameOutcome.CLASSIFIED}
    assert all(step.prediction is not None for step in result.steps)
    assert [step.index for step in recorder.steps] == [0, 1, 2, 3, 4]
    assert recorder.ends == [result]
    assert not result.interrupted
    assert list(result.steps[0].milliseconds) == ["register", "segment", "fuse", "grid", "classify"]


def test_frames_before_the_first_object_must_show_the_floor() -> None:
    pipeline = make_pipeline()
    shots = list(frames(4))
    too_high = RigidTransform.from_translation([0, 0, 0.3])
    wrong = [dataclasses.replace(f, T_map_camera=too_high * f.pose) for f in shots]
    given = [wrong[0], wrong[1], shots[2], wrong[3]]
    outcomes = [pipeline.step(frame).outcome for frame in given]
    assert outcomes == [
        FrameOutcome.NO_FLOOR,
        FrameOutcome.NO_FLOOR,
        FrameOutcome.CLASSIFIED,
        FrameOutcome.CLASSIFIED,
    ]


def test_repr_of_steps_and_results_is_short() -> None:
    result = run(frames(2))
    last = result.last
    assert last is not None
    answer = repr(last.prediction)
    assert answer.startswith("Prediction(")
    assert repr(last) == f"RecognitionStep(frame 1, 'classified', {answer})"
    assert repr(result) == f"RecognitionResult(2 steps, {answer})"
    assert repr(last.model) == f"ObjectModel({len(last.model.points_xyz)} points, 2 frames)"
    early = RecognitionResult((), interrupted=True)
    assert repr(early) == "RecognitionResult(0 steps, no prediction, interrupted)"


def test_the_answer_is_the_classification_of_the_grid_of_the_step() -> None:
    pipeline = make_pipeline()
    for step in map(pipeline.step, frames(3)):
        assert step.grid is not None
        assert step.prediction is not None
        again = pipeline.classifier.classify_grid(step.grid, metric=True)
        assert step.prediction.probabilities == again.probabilities
        np.testing.assert_array_equal(step.grid.states, step.model.occupancy(step.grid.grid).states)


class ManyViews(VolumeClassifier):
    def __init__(self, count: int) -> None:
        super().__init__()
        self.count = count
        self.asked: list[tuple[OccupancyGrid, ...]] = []

    @property
    def input_spec(self) -> GridSpec:
        input_spec = super().input_spec
        return dataclasses.replace(input_spec, azimuth_views=self.count, dithered=True, margin=1.5)

    def classify_grid(self, *views: OccupancyGrid, **options) -> Prediction:
        self.asked.append(views)
        return super().classify_grid(*views, **options)


def test_a_scan_is_classified_on_a_traced_grid_and_grids_of_its_points() -> None:
    """As the model card says."""
    classifier = ManyViews(4)
    pipeline = RecognitionPipeline(GroundSegmentation(), KnownPoses(), classifier)
    step = [pipeline.step(frame) for frame in frames(3)][-1]
    traced, *others = classifier.asked[-1]
    assert traced is step.grid
    np.testing.assert_array_equal(traced.states, step.model.occupancy(traced.grid).states)
    bounds = classifier.input_spec.all_bounds(traced.grid)
    assert [view.grid for view in others] == bounds[1:]
    points = step.model.cloud().points_xyz
    for view in others:
        np.testing.assert_array_equal(view.states, view.grid.hits(points).states)


@pytest.mark.parametrize("count", [1, 2, 4, 5, 8])
def test_a_frame_is_classified_on_at_most_four_grids_and_the_end_on_all(count: int) -> None:
    classifier = ManyViews(count)
    pipeline = RecognitionPipeline(GroundSegmentation(), KnownPoses(), classifier)
    last = run_pipeline(pipeline, frames(3)).last
    few = min(count, 4)
    assert [len(views) for views in classifier.asked] == [few] * 3 + [count]
    as_a_frame = ManyViews(few).input_spec
    for views in classifier.asked[:3]:
        assert [view.grid for view in views] == as_a_frame.all_bounds(views[0].grid)
    asked = classifier.asked[-1]
    assert last.prediction == VolumeClassifier.classify_grid(
        classifier, *asked, metric=True, coverage=last.coverage
    )
    assert not pipeline.finalise()


def test_after_a_pause_frames_are_classified_on_few_grids_again() -> None:
    classifier = ManyViews(8)
    pipeline = RecognitionPipeline(GroundSegmentation(), KnownPoses(), classifier)
    for frame in frames(2):
        pipeline.step(frame)
        assert pipeline.finalise()
        assert not pipeline.finalise()
    assert [len(views) for views in classifier.asked] == [4, 8, 4, 8]


def test_an_interrupted_run_that_ends_without_depth_is_classified_on_all_grids() -> None:
    shots = list(frames(3))
    blind = dataclasses.replace(shots[2], depth=np.full_like(shots[2].depth, np.nan))

    def interrupted():
        yield from [*shots[:2], blind]
        raise KeyboardInterrupt

    classifier, recorder = ManyViews(8), StepRecorder()
    pipeline = RecognitionPipeline(GroundSegmentation(), KnownPoses(), classifier)
    with pytest.raises(KeyboardInterrupt):
        run_pipeline(pipeline, interrupted(), [recorder])
    assert [len(views) for views in classifier.asked] == [4, 4, 8]
    assert recorder.ends[0].prediction == pipeline.prediction != recorder.steps[-1].prediction
    assert (recorder.ends[0].interrupted, recorder.ends[0].end_reason) == (True, "")


@pytest.mark.parametrize("good", [2, 3])
def test_a_classifier_that_begins_to_fail_does_not_lose_the_run(good: int) -> None:
    """At a frame, or at the classification of all grids at the end."""

    class Failing(ManyViews):
        def classify_grid(self, *views: OccupancyGrid, **options) -> Prediction:
            if len(self.asked) == good:
                raise WeightsError(f"broken at {len(views)} grids")
            return super().classify_grid(*views, **options)

    recorder = StepRecorder()
    pipeline = RecognitionPipeline(GroundSegmentation(), KnownPoses(), Failing(8))
    with pytest.raises(WeightsError, match="4" if good < 3 else "8"):
        run_pipeline(pipeline, frames(3), [recorder])
    assert len(recorder.ends) == 1
    assert recorder.ends[0].interrupted
    assert recorder.ends[0].end_reason.startswith("broken at")
    assert len(recorder.ends[0].steps) == good


def test_a_fused_frame_whose_classification_failed_is_classified_at_the_end() -> None:
    class FailsOnce(ManyViews):
        def classify_grid(self, *views: OccupancyGrid, **options) -> Prediction:
            prediction = super().classify_grid(*views, **options)
            if len(self.asked) == 3:
                raise WeightsError("broken for once")
            return prediction

    pipeline = RecognitionPipeline(GroundSegmentation(), KnownPoses(), FailsOnce(1))
    first, second, third = frames(3)
    pipeline.step(first)
    pipeline.step(second)
    with pytest.raises(WeightsError):
        pipeline.step(third)
    before = pipeline.prediction
    assert pipeline.finalise()
    assert pipeline.prediction is not before
    assert not pipeline.finalise()


def test_a_result_keeps_only_the_last_model() -> None:
    recorder = StepRecorder()
    result = run(frames(4), recorder)
    assert [len(step.model.sums) > 0 for step in result.steps] == [False, False, False, True]
    assert [step.grid is None for step in result.steps] == [True, True, True, False]
    assert result.last.model is recorder.steps[-1].model
    assert [step.prediction for step in result.steps] == [
        step.prediction for step in recorder.steps
    ]


def test_coverage_grows_with_every_frame_and_is_part_of_the_answer() -> None:
    steps = run(frames(8)).steps
    coverage = [step.coverage for step in steps]
    assert coverage[0] == pytest.approx(0.25, abs=0.03)
    assert (np.diff(coverage) >= 0).all()
    assert coverage[-1] == 1.0
    assert [step.prediction.coverage for step in steps] == coverage


def test_a_step_is_confident_by_the_confidence_rule_of_the_classifier() -> None:
    anything = ConfidenceRule(coverage=(0.5,), probability=(0.0,))
    steps = run_pipeline(make_pipeline(VolumeClassifier(anything)), frames(8)).steps
    assert [step.confident for step in steps] == [step.coverage >= 0.5 for step in steps]
    assert {step.confident for step in steps} == {True, False}
    first, last = steps[0].summary(), steps[-1].summary()
    assert (first["confident"], first["reason"]) == (False, "at least 50 % coverage is needed")
    assert (last["confident"], last["reason"], last["in_distribution"]) == (True, "", True)
    assert last["coverage"] == 1.0
    answer = steps[-1].answer
    assert (answer.coverage, answer.confident, answer.in_distribution) == (1.0, True, True)


def test_earlier_steps_are_not_changed_by_later_ones() -> None:
    pipeline = make_pipeline()
    shots = list(frames(3))
    first = pipeline.step(shots[0])
    points, states = first.model.points_xyz.copy(), first.grid.states.copy()
    for frame in shots[1:]:
        pipeline.step(frame)
    np.testing.assert_array_equal(first.model.points_xyz, points)
    np.testing.assert_array_equal(first.grid.states, states)
    with pytest.raises(dataclasses.FrozenInstanceError):
        first.index = 7  # type: ignore[misc]


def test_the_shape_of_the_model_does_not_depend_on_the_start() -> None:
    one, other = (run(frames(12, start)).last.model.cloud() for start in (0.0, 2.0))
    np.testing.assert_allclose(
        one.weights @ one.points_xyz, other.weights @ other.points_xyz, atol=0.01
    )
    for outermost in (np.min, np.max):
        np.testing.assert_allclose(
            outermost(one.points_xyz, axis=0), outermost(other.points_xyz, axis=0), atol=0.02
        )


def test_frames_without_depth_are_reported_and_change_nothing() -> None:
    shots = list(frames(4))
    pipeline = make_pipeline()
    before = pipeline.step(shots[0])
    step = pipeline.step(blind(shots[1]))
    assert (step.outcome, step.pose, step.index) == (FrameOutcome.NO_DEPTH, None, 1)
    assert step.model is before.model
    assert step.prediction is before.prediction
    assert pipeline.step(shots[2]).outcome == FrameOutcome.CLASSIFIED


def test_frames_without_depth_at_the_start_have_no_answer() -> None:
    step = make_pipeline().step(blind(next(frames(1))))
    assert (step.prediction, step.grid, step.coverage) == (None, None, 0.0)


def test_frames_without_the_object_are_reported_and_change_nothing() -> None:
    shots = list(frames(2))
    away = RigidTransform.from_rotation(Rotation.from_euler("z", 90, degrees=True))
    # Only floor: the same picture with the object's depth gone.
    pipeline = make_pipeline()
    pipeline.step(shots[0])
    moved = RigidTransform.from_translation([4.0, 0.0, 0.0]) * away
    step = pipeline.step(shots[1].at(moved * shots[1].pose))
    assert step.outcome == FrameOutcome.NO_OBJECT
    assert step.object_pixels == 0
    assert step.model.frames == 1


@pytest.mark.parametrize("factor", [1000, 0.001])
def test_depth_in_the_wrong_unit_is_reported_and_not_fused(factor: float) -> None:
    shots = list(frames(2))
    pipeline = make_pipeline()
    pipeline.step(shots[0])
    wrong = RgbdFrame(
        shots[1].depth * factor, shots[1].camera, shots[1].stamp, shots[1].T_map_camera
    )
    step = pipeline.step(wrong)
    assert step.outcome == FrameOutcome.WRONG_UNIT
    assert step.model.frames == 1


@pytest.mark.parametrize("late", [0.0, 0.5])
def test_frames_out_of_order_or_with_equal_stamps_are_reported_and_skipped(late: float) -> None:
    shots = list(frames(3))
    pipeline = make_pipeline()
    pipeline.step(shots[0])
    before = pipeline.step(shots[1])
    again = RgbdFrame(shots[2].depth, shots[2].camera, shots[1].stamp - late, shots[2].T_map_camera)
    step = pipeline.step(again)
    assert (step.outcome, step.pose) == (FrameOutcome.OUT_OF_ORDER, None)
    assert step.model is before.model
    assert pipeline.step(shots[2]).outcome == FrameOutcome.CLASSIFIED


def test_too_few_object_pixels_are_reported() -> None:
    class OnePatch(Segmentation):
        def object_mask(self, frame, known_xyz=None):
            mask = np.zeros(frame.depth.shape, bool)
            mask[100:102, 100:102] = True
            return mask

    pipeline = make_pipeline()
    pipeline.segmentation = OnePatch()
    step = pipeline.step(next(frames(1)))
    assert step.outcome == FrameOutcome.TOO_LITTLE
    assert step.prediction is None
    assert step.pose is not None


def test_a_frame_without_a_pose_ends_the_run_and_keeps_the_steps_before() -> None:
    shots = list(frames(3))
    lost = RgbdFrame(shots[1].depth, shots[1].camera, shots[1].stamp)
    recorder = StepRecorder()
    with pytest.raises(InputError, match="no pose"):
        run([shots[0], lost, shots[2]], recorder)
    assert len(recorder.ends) == 1
    assert recorder.ends[0].interrupted
    assert "no pose" in recorder.ends[0].end_reason
    assert len(recorder.ends[0].steps) == 1


def test_a_further_run_counts_its_frames_from_0_and_goes_on_with_the_object() -> None:
    shots = list(frames(5))
    pipeline = make_pipeline()
    run_pipeline(pipeline, shots[:3])
    further = run_pipeline(pipeline, shots[3:])
    assert [step.index for step in further.steps] == [0, 1]
    assert further.last.model.frames == 5
    figure = Figure()
    draw_probabilities(figure.add_subplot(), further, RunPath())


def test_a_run_without_frames_ends_without_an_answer() -> None:
    result = run([])
    assert (result.last, result.prediction, result.steps) == (None, None, ())


def test_a_custom_pose_estimator_is_used() -> None:
    """As registration does, it corrects the pose of the frame."""
    drift = RigidTransform.from_translation([0.03, -0.02, 0.01])

    class Correcting(PoseEstimator):
        def track(self, frame):
            return PoseEstimate(drift.inv() * frame.pose, inliers=5, residual=0.002)

    parts = make_pipeline()
    pipeline = RecognitionPipeline(parts.segmentation, Correcting(), parts.classifier)
    drifted = [frame.at(drift * frame.pose) for frame in frames(3)]
    result = run_pipeline(pipeline, drifted)
    true = run(frames(3))
    assert result.steps[0].pose.inliers == 5
    np.testing.assert_allclose(
        result.last.model.cloud().points_xyz.mean(axis=0),
        true.last.model.cloud().points_xyz.mean(axis=0),
        atol=0.004,
    )


def test_a_pipeline_of_the_same_parts_starts_empty() -> None:
    pipeline = make_pipeline()
    again = RecognitionPipeline(
        pipeline.segmentation, pipeline.tracker.estimator, pipeline.classifier
    )
    assert again.model.frames == 0


def test_large_object_is_classified_by_its_preview_until_frames_end(monkeypatch) -> None:
    shots = list(frames(6))
    plain = run(shots).last
    monkeypatch.setattr(object_model, "MAX_FINE_VOXELS", 3000)
    pipeline = make_pipeline()
    for shot in shots:
        pipeline.step(shot)
    assert pipeline.model.preview is not pipeline.model
    rough = pipeline.grid.occupied
    assert pipeline.finalise()
    np.testing.assert_array_equal(pipeline.grid.occupied, plain.grid.occupied)
    assert not pipeline.finalise()
    # On the way it is of fewer points, and about the same.
    both = (rough & pipeline.grid.occupied).sum()
    assert 0.5 < both / (rough | pipeline.grid.occupied).sum() < 1
