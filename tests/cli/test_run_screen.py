"""What a run prints while it continues, where standard error is no terminal."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.cli.run_screen import RunScreen, answer_sentences
from circumspect.recognition import FrameOutcome, RecognitionResult, RecognitionStep
from circumspect.reconstruction import ObjectModel
from circumspect.tracking import PoseEstimate, TrackingState


def lines(pose: PoseEstimate, outcome: str, capsys: pytest.CaptureFixture) -> str:
    step = RecognitionStep(0, 0.0, outcome, pose, 0, 0.25, ObjectModel(), None, None)
    with RunScreen("scanning", 10) as screen:
        screen.on_step(step)
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("state", "reason", "end"),
    [
        (TrackingState.TRACKING, "", None),
        (
            TrackingState.DEAD_RECKONING,
            "2 poses are possible",
            "pose not reliable: 2 poses are possible",
        ),
        (
            TrackingState.LOST,
            "the scans contradict the map",
            "pose not reliable: the scans contradict the map",
        ),
    ],
)
def test_why_a_pose_is_not_reliable_follows_the_answer(
    state: TrackingState, reason: str, end: str | None, capsys: pytest.CaptureFixture
) -> None:
    pose = PoseEstimate(RigidTransform.identity(), state, reason)
    outcome = FrameOutcome.NO_POSE if reason else FrameOutcome.CLASSIFIED
    text = lines(pose, outcome, capsys)
    assert "frame   1/10  coverage  25 %" in text
    assert text.rstrip().endswith(end or outcome)


def step(
    label: str = "chair", known: bool = True, coverage: float = 1.0, probability: float = 0.98
) -> RecognitionStep:
    shares = np.array([probability, 1 - probability])
    answer = Prediction.from_probabilities(
        (label, "sofa"), shares, in_distribution=known, coverage=coverage
    )
    return RecognitionStep(
        0, 0.0, FrameOutcome.CLASSIFIED, None, 9, coverage, ObjectModel(), None, answer
    )


@pytest.mark.parametrize(
    ("known", "coverage", "line"),
    [
        (True, 1.0, "coverage 100 %  chair (98 %)"),
        (True, 0.74, "coverage  74 %  chair (98 %), not confident"),
        (False, 1.0, "coverage 100 %  unknown object (nearest: chair 98 %), not confident"),
    ],
)
def test_progress_shows_coverage_and_whether_the_answer_is_confident(
    known: bool, coverage: float, line: str, capsys: pytest.CaptureFixture
) -> None:
    with RunScreen("scanning", 10) as screen:
        screen.on_step(step(known=known, coverage=coverage))
    assert capsys.readouterr().err.rstrip().endswith(line)


@pytest.mark.parametrize(
    ("changes", "truth", "sentence"),
    [
        ({}, None, "Result: chair (98 %), 1 frame, 100 % coverage. Confident."),
        ({}, "chair", "Result: chair (98 %), 1 frame, 100 % coverage. Confident. Correct."),
        (
            {"coverage": 0.33}, "bed",
            "Result: chair (98 %), 1 frame, 33 % coverage. Not confident: at least 75 % coverage "
            "is needed. Incorrect: the true class is bed.",
        ),
        (
            {"probability": 0.55}, None,
            "Result: chair or sofa (55 % / 45 %), 1 frame, 100 % coverage. Not confident: a "
            "probability of at least 90 % is needed.",
        ),
        (
            {"known": False}, "chair",
            "Result: unknown object (nearest: chair 98 %), 1 frame, 100 % coverage. Not "
            "confident: the object is unlike the trained classes. The true class is chair.",
        ),
    ],
)  # fmt: skip
def test_the_result_is_a_sentence_with_coverage_and_confidence(
    changes: dict[str, Any], truth: str | None, sentence: str
) -> None:
    assert answer_sentences(RecognitionResult((step(**changes),)), truth) == [sentence]


def test_an_answer_that_changed_after_the_last_frame_is_explained() -> None:
    with RunScreen("scanning", 10) as screen:
        assert screen.label is None
        screen.on_step(step("desk"))
        screen.on_step(replace(step(), prediction=None))
    result = RecognitionResult((step("table"),))
    verdict, why = answer_sentences(result, "table", screen.label)
    assert verdict == "Result: table (98 %), 1 frame, 100 % coverage. Confident. Correct."
    assert why == (
        "After the last frame the answer was desk; the result is that of the whole model, after "
        "loop closure."
    )
    for same in ("table", None):
        assert answer_sentences(result, "table", same) == [verdict]
    nothing = RecognitionResult((replace(step(), prediction=None),))
    assert len(answer_sentences(nothing, None, "desk")) == 1


def test_frames_that_are_not_part_of_the_answer_follow_it() -> None:
    steps = [replace(step(), outcome=FrameOutcome.NO_OBJECT)] * 3 + [step()]
    sentences = answer_sentences(RecognitionResult(tuple(steps)), None, "chair")
    assert sentences[1:] == ["Frames that are not part of it: no object in view (3)."]
