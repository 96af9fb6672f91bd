"""What is told of a run while it goes on, where standard error is no terminal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.classification import Prediction
from circumspect.cli.run_screen import RunScreen, answer_sentences
from circumspect.mapping import ObjectModel, PoseEstimate
from circumspect.pipeline import (
    CLASSIFIED,
    NO_OBJECT,
    NO_POSE,
    RecognitionResult,
    RecognitionStep,
)

FREE = "the scene leaves one direction free"


def lines(pose: PoseEstimate, outcome: str, capsys: pytest.CaptureFixture) -> str:
    step = RecognitionStep(0, 0.0, outcome, pose, 0, 0.25, ObjectModel(), None, None)
    with RunScreen("scanning", 10) as screen:
        screen.on_step(step)
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("gate", "doubt", "told"),
    [
        ("open", "", None),
        (FREE, "", f"gate closed: {FREE}"),
        ("open", "a frame must agree first", "pose not certain: a frame must agree first"),
        ("few inliers", "lost", "pose not certain: few inliers; lost"),
    ],
)
def test_what_speaks_against_a_pose_follows_the_answer(
    gate: str, doubt: str, told: str | None, capsys: pytest.CaptureFixture
) -> None:
    pose = PoseEstimate(RigidTransform.identity(), gate=gate, doubt=doubt)
    outcome = NO_POSE if doubt else CLASSIFIED
    text = lines(pose, outcome, capsys)
    assert "frame   1/10  seen  25%" in text
    assert text.rstrip().endswith(told or outcome)


def step(label: str = "chair", known: bool = True, seen: float = 1.0) -> RecognitionStep:
    names = (label, "sofa")
    answer = Prediction.from_probabilities(names, np.array([0.98, 0.02]), known=known)
    return RecognitionStep(0, 0.0, CLASSIFIED, None, 9, seen, ObjectModel(), None, answer)


@pytest.mark.parametrize(
    ("known", "seen", "told"),
    [
        (True, 1.0, "seen 100%  chair 0.98"),
        (True, 0.74, "seen  74%  perhaps chair 0.98"),
        (False, 1.0, "seen 100%  unknown, nearest chair 0.98"),
        (False, 0.5, "seen  50%  unknown, nearest chair 0.98"),
    ],
)
def test_an_answer_that_is_not_conclusive_is_told_as_the_picture_tells_it(
    known: bool, seen: float, told: str, capsys: pytest.CaptureFixture
) -> None:
    with RunScreen("scanning", 10) as screen:
        screen.on_step(step(known=known, seen=seen))
    assert capsys.readouterr().err.rstrip().endswith(told)


def test_an_answer_that_changed_after_the_last_frame_says_why() -> None:
    with RunScreen("scanning", 10) as screen:
        assert screen.label is None
        screen.on_step(step("desk"))
        screen.on_step(replace(step(), prediction=None))
    result = RecognitionResult((step("table"),))
    verdict, why = answer_sentences(result, "table", screen.label)
    assert verdict.startswith("Right: it is a table")
    assert why == (
        "After the last frame it was still named desk; what is asked in the end is all of the "
        "model, its loops closed."
    )
    for same in ("table", None):
        assert answer_sentences(result, "table", same) == [verdict]
    nothing = RecognitionResult((replace(step(), prediction=None),))
    assert len(answer_sentences(nothing, None, "desk")) == 1


def test_frames_that_are_not_part_of_the_answer_follow_it() -> None:
    steps = [replace(step(), outcome=NO_OBJECT)] * 3 + [step()]
    told = answer_sentences(RecognitionResult(tuple(steps)), None, "chair")
    assert told[1:] == ["Frames that are not part of it: no object in view (3)."]
