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
        self._substitutes: dict[int, tuple[int, NDArray[np.floating]]] = {}

    def __len__(self) -> int:
        return len(self._substitutes)

    def add(self, culled: int, substitute: int, T_substitute_culled: NDArray[np.floating]) -> None:
        """Record a culled keyframe.

        Args:
            culled: Its number.
            substitute: Number of the keyframe that represents it.
            T_substitute_culled: (4, 4) its pose there.
        """
        self._substitutes[culled] = (substitute, T_substitute_culled)
        if len(self._substitutes) > self._max:
            del self._substitutes[next(iter(self._substitutes))]

    def substitute(
        self, number: int, T_number_x: NDArray[np.floating]
    ) -> tuple[int, NDArray[np.floating]]:
        """The keyframe that represents a number, and a pose in it.

        Args:
            number: A keyframe, which may have been culled.
            T_number_x: (4, 4) a pose in it.

        Returns:
            The number of a keyframe that exists or was forgotten, and `T_substitute_x`.
        """
        while number in self._substitutes:
            number, T_substitute_number = self._substitutes[number]
            T_number_x = T_substitute_number @ T_number_x
        return number, T_number_x
