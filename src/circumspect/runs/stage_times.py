"""Times of the stages of a run."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

import numpy as np

from circumspect.recognition import RecognitionStep

PLAN, FRAME = "plan", "frame"


def stage_lists(
    steps: Sequence[RecognitionStep], plan: Sequence[float] = ()
) -> dict[str, list[float]]:
    """Stage to its times [ms], one for each frame that got there; "frame" is the sum of a frame.

    Args:
        steps: Of a run.
        plan: Planning time after each frame [ms]; the last frame may have none.
    """
    times: dict[str, list[float]] = {}
    for step, planned in zip_longest(steps, plan):
        stages = dict(step.milliseconds) | ({} if planned is None else {PLAN: planned})
        for name, spent in stages.items():
            times.setdefault(name, []).append(spent)
        if stages:
            times.setdefault(FRAME, []).append(sum(stages.values()))
    return times


def stage_times(
    steps: Sequence[RecognitionStep], plan: Sequence[float] = ()
) -> dict[str, dict[str, float]]:
    """Stage to median and 95th percentile [ms]; see `stage_lists`."""
    return {
        name: {
            "median": round(float(np.median(spent)), 3),
            "p95": round(float(np.percentile(spent, 95)), 3),
        }
        for name, spent in stage_lists(steps, plan).items()
    }
