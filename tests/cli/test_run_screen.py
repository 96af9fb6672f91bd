"""What is told of a run while it goes on, where standard error is no terminal."""

from __future__ import annotations

import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.cli.run_screen import RunScreen
from circumspect.mapping import ObjectModel, PoseEstimate
from circumspect.pipeline import CLASSIFIED, NO_POSE, RecognitionStep

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
