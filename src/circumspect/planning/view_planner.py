"""The interface of everything that chooses views."""

from __future__ import annotations

from abc import ABC, abstractmethod

from circumspect.planning.next_view import Finished, NextView
from circumspect.planning.rounds import all_tried, bearing_turned, left_out
from circumspect.planning.situation import Situation

ROUND_COMPLETE = "once round the object"
AS_FAR_AS_POSSIBLE = "round the object as far as it can be reached"
FULL_ROUND_DEG = 360.0


class ViewPlanner(ABC):
    """Chooses the robot's next view of an object on its left."""

    @abstractmethod
    def next_view(self, situation: Situation) -> NextView | Finished:
        """Where to look from next; asked when the robot has come to a stop."""

    def enough(self, situation: Situation) -> Finished | None:
        """Whether what was seen is enough; asked after every frame, also while driving."""
        if bearing_turned(situation) >= FULL_ROUND_DEG:
            return Finished(AS_FAR_AS_POSSIBLE if left_out(situation) else ROUND_COMPLETE)
        if all_tried(situation):
            return Finished(AS_FAR_AS_POSSIBLE)
        return None
