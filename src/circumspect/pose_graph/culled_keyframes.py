"""Which keyframe represents one that was culled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MAX_CULLED = 4096
"""So many culled keyframes are remembered; the oldest are forgotten first."""


class CulledKeyframes:
    """Poses of culled keyframes in the keyframes that represent them."""

    def __init__(self, max_culled: int = MAX_CULLED) -> None:
        """Start empty.

        Args:
            max_culled: So many are remembered.
        """
        self._max = max_culled
        self._heirs: dict[int, tuple[int, NDArray[np.floating]]] = {}

    def __len__(self) -> int:
        return len(self._heirs)

    def add(self, culled: int, heir: int, T_heir_culled: NDArray[np.floating]) -> None:
        """Record a culled keyframe.

        Args:
            culled: Its number.
            heir: Number of the keyframe that represents it.
            T_heir_culled: (4, 4) its pose there.
        """
        self._heirs[culled] = (heir, T_heir_culled)
        if len(self._heirs) > self._max:
            del self._heirs[next(iter(self._heirs))]

    def heir(
        self, number: int, T_number_x: NDArray[np.floating]
    ) -> tuple[int, NDArray[np.floating]]:
        """The keyframe that represents a number, and a pose in it.

        Args:
            number: A keyframe, which may have been culled.
            T_number_x: (4, 4) a pose in it.

        Returns:
            The number of a keyframe that exists, or of one that was forgotten; and `T_heir_x`.
        """
        while number in self._heirs:
            number, T_heir_number = self._heirs[number]
            T_number_x = T_heir_number @ T_number_x
        return number, T_number_x
