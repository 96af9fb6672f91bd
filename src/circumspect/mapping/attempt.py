"""One way to place a frame."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from circumspect.mapping.gate import Verdict
from circumspect.mapping.motion import CLOSE_SHIFT, CLOSE_TURN, Belief, apart
from circumspect.registration import Registration


@dataclass(frozen=True, eq=False)
class Attempt:
    """A belief about one frame's pose, and what speaks for it.

    Attributes:
        belief: The pose after the frame was looked at.
        verdict: Of the gate.
        source: Of the prediction.
        found: The registration that the verdict is of; None where there was none.
        refused: In its place one that leapt or is ambiguous: nothing goes by it, it is only told.
        prediction: Where it began; None where that is still the belief.
    """

    belief: Belief
    verdict: Verdict
    source: str
    found: Registration | None = None
    refused: Registration | None = None
    prediction: Belief | None = None

    @property
    def told(self) -> Registration | None:
        """What came of the registration, believed or not."""
        return self.refused if self.found is None else self.found

    @property
    def distance(self) -> float:
        """Mean distance of the frame to the map [m]; the larger, the worse."""
        return np.inf if self.found is None else self.found.distance

    def wins(
        self, below: float, usual: float, in_order: bool, expected: Belief, rival: Belief
    ) -> bool:
        """Whether this takes the place of a first attempt from a rival prediction.

        At the edge of the map any frame comes nearer to it when it slides back. A fit further from
        where it was expected than the predictions are from each other bears out neither of them:
        it does not replace one that is in order, and no other unless it lies as frames do.

        Args:
            below: It must come nearer to the map than this [m].
            usual: Mean distance to the map [m] up to which a frame fits as the last ones did.
            in_order: Nothing speaks against the first one.
            expected: The prediction that it began with.
            rival: That of the first.
        """
        shift, turn = apart(expected, self.belief)
        rival_shift, rival_turn = apart(expected, rival)
        slid = shift > max(CLOSE_SHIFT, rival_shift) or turn > max(CLOSE_TURN, rival_turn)
        doubtful = slid and (in_order or self.distance > usual)
        return self.verdict.is_open and self.distance < below and not doubtful

    def doubted(self, doubt: tuple[float, float]) -> Attempt:
        """The same, less sure by standard deviations of turn [rad] and shift [m]."""
        added = np.diag([doubt[0]] * 3 + [doubt[1]] * 3) ** 2
        return replace(
            self, belief=Belief(self.belief.T_map_camera, self.belief.covariance + added)
        )
