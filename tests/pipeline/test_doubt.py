from __future__ import annotations

import numpy as np
import pytest

from circumspect.classification import Prediction
from circumspect.pipeline.doubt import FEW_SIDES, OTHERS, doubt


@pytest.mark.parametrize(
    ("probability", "known", "seen", "told"),
    [
        (0.95, True, 0.75, ""),
        (0.95, True, 0.74, FEW_SIDES),
        (0.89, True, 1.0, OTHERS),
        (0.89, True, 0.5, FEW_SIDES),
        (0.95, False, 1.0, ", not sure to be of any class"),
    ],
)
def test_an_answer_to_rely_on_is_known_likely_and_of_enough_sides(
    probability: float, known: bool, seen: float, told: str
) -> None:
    shares = np.array([probability, 1 - probability])
    assert (
        doubt(Prediction.from_probabilities(("chair", "sofa"), shares, known=known), seen) == told
    )
