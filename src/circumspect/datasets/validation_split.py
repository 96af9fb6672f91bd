"""Which objects of the training split are held back to choose by."""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray


def validation_split(
    names: NDArray[np.str_], share: float = 0.15, salt: str = ""
) -> NDArray[np.bool_]:
    """Mark the validation objects by a hash of their names.

    An object keeps its side whatever else the set holds.

    Args:
        names: (n,) object names.
        share: Share of the objects to mark, about, 0 … 1.
        salt: Another salt gives another split.

    Returns:
        (n,) True for validation.
    """
    return np.array([_fraction(salt + str(name)) < share for name in names], dtype=bool)


def _fraction(text: str) -> float:
    return int(hashlib.sha256(text.encode()).hexdigest()[:8], 16) / 2**32
