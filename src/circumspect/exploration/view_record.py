"""Outcomes of the views of a scan."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from circumspect.planning import NextView


class ViewOutcome(StrEnum):
    """Outcome of a view; the values are the texts in a scan's file.

    The text of `NO_PATH` is replaced by the reason that the path search returns.
    """

    REACHED = "reached"
    NO_PATH = "no path"
    BLOCKED = "blocked on the way"
    OBSTRUCTED = "something stands in the way"
    NOT_IN_VIEW = "the object is not in view from there"
    UNRELIABLE_POSE = "the pose was not reliable"
    ALREADY_THERE = "the robot stands there already"


@dataclass(frozen=True, eq=False)
class ViewRecord:
    """Outcome of a view that the planner chose.

    Attributes:
        view: The view.
        outcome: Its outcome.
        reason: The same in words.
        path_xy: (n, 2) [m] the planned path to it; empty without one.
        frame: Number of frames at that time.
    """

    view: NextView
    outcome: ViewOutcome
    reason: str
    path_xy: NDArray[np.float64]
    frame: int
