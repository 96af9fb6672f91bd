"""Why an answer is not one to rely on."""

from __future__ import annotations

from circumspect.classification import Prediction
from circumspect.planning import ENOUGH_SEEN

FEW_SIDES = ", not sure: too little of it was seen"


def doubt(prediction: Prediction, seen: float) -> str:
    """What a sentence about the answer ends with.

    Args:
        prediction: The answer.
        seen: Share of the directions around the object from which it has been seen, 0 … 1.

    Returns:
        Empty where nothing speaks against the answer: the object is like those of the classes, and
        enough of it was seen.
    """
    return prediction.doubt or (FEW_SIDES if seen < ENOUGH_SEEN else "")
