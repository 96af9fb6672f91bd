"""Which keyframe stands for one that gave way."""

from __future__ import annotations

from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed

MOST = 4096
"""So many that gave way are remembered: at 0.2 m each, more than 800 m of driving."""


class Heirs:
    """Where keyframes that gave way lie in those that stand for them; bounded, oldest forgotten."""

    def __init__(self, most: int = MOST) -> None:
        """Nothing gave way yet.

        Args:
            most: So many are remembered.
        """
        self._most = most
        self._of: dict[int, tuple[int, RigidTransform]] = {}

    def __len__(self) -> int:
        return len(self._of)

    def gave_way(self, gone: int, heir: int, T_heir_gone: RigidTransform) -> None:
        """Remember one more.

        Args:
            gone: The number of the keyframe that gives way.
            heir: The number of the one that stands for it.
            T_heir_gone: Where it lies in that.
        """
        self._of[gone] = (heir, T_heir_gone)
        if len(self._of) > self._most:
            del self._of[next(iter(self._of))]

    def living(self, number: int, T_number_x: RigidTransform) -> tuple[int, RigidTransform]:
        """The keyframe that stands for a number by now, and a pose in it.

        Args:
            number: A keyframe, even one that gave way.
            T_number_x: A pose in it.

        Returns:
            A number that nothing is remembered of: of a keyframe that lives, or was forgotten.
        """
        while number in self._of:
            number, T_heir_number = self._of[number]
            T_number_x = composed(T_heir_number, T_number_x)
        return number, T_number_x
