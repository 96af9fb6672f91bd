"""Why an answer is not one to rely on."""

from __future__ import annotations

from circumspect.classification import Prediction
from circumspect.planning import ENOUGH_SEEN

LIKELY = 0.9
"""An answer that is less probable is by its own account wrong more than once in ten times."""
FEW_SIDES = ", not sure: too little of it was seen"
OTHERS = ", not sure: it may well be something else"


def doubt(prediction: Prediction, seen: float) -> str:
    """What a sentence about the answer ends with.

    Args:
        prediction: The answer.
        seen: Share of the directions around the object from which it has been seen, 0 … 1.

    Returns:
        Empty where nothing speaks against the answer: the object is like those of the classes,
        enough of it was seen, and no other class is likely.
    """
    if prediction.doubt:
        return prediction.doubt
    if seen < ENOUGH_SEEN:
        return FEW_SIDES
    return "" if prediction.probability >= LIKELY else OTHERS
