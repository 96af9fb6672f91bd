"""What became of the views of a scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.planning import NextView

REACHED = "reached"
BLOCKED = "blocked on the way"
CLOSED = "something stands in the way"
HIDDEN = "the object is not in view from there"
UNSURE = "the pose was not reliable"
NO_NEWS = "the robot stands there already"


@dataclass(frozen=True, eq=False)
class ViewRecord:
    """What became of a view that the planner chose.

    Attributes:
        view: The view.
        outcome: `REACHED`, or why not.
        path_xy: (n, 2) [m] the way that was planned to it; empty without one.
        frame: Number of frames when that was known.
    """

    view: NextView
    outcome: str
    path_xy: NDArray[np.float64]
    frame: int
