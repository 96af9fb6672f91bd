"""How well a score separates objects of known classes from others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata


def area_under_curve(known: NDArray[np.float64], unknown: NDArray[np.float64]) -> float:
    """Chance that a known object scores higher than an unknown one (area under the ROC curve).

    Args:
        known: (n,) scores; n at least 1.
        unknown: (m,) scores; m at least 1.
    """
    ranks = rankdata(np.concatenate([known, unknown]))[: len(known)]
    return float((ranks - (len(known) + 1) / 2).sum() / (len(known) * len(unknown)))
