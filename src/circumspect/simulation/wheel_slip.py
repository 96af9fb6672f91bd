"""Wheel travel that does not become motion."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from circumspect.errors import InputError


class WheelSlip:
    """Each wheel's slip changes with the patch of floor it rolls on, for each wheel by itself.

    On every `PATCH` metres of its travel a wheel loses a share drawn from an exponential
    distribution with the given mean: mostly little, sometimes much. The way lost so has the
    mean `share` and the variance `share`² `PATCH` a metre.
    """

    PATCH: ClassVar[float] = 0.1
    """Travel on one patch of floor [m]."""
    WORST: ClassVar[float] = 0.9
    """The largest share lost on a patch."""

    def __init__(self, share: float, rng: np.random.Generator | int = 0) -> None:
        """Lay the floor.

        Args:
            share: Mean share of the travel that is lost; 0 is a wheel that grips.
            rng: A generator or a seed.

        Raises:
            InputError: The share lies outside 0 … 0.5.
        """
        if not 0 <= share <= 0.5:
            raise InputError(f"slip is a share from 0 to 0.5, not {share}")
        self._share = share
        # A stream for each wheel: the way of one does not change the floor of the other.
        self._rngs = np.random.default_rng(rng).spawn(2)
        self._travels = [0.0, 0.0]
        self._patches = [-1, -1]
        self._lost = [0.0, 0.0]

    def lost(self, wheel: int) -> float:
        """The share that a wheel (0 left, 1 right) loses where it now stands."""
        patch = int(self._travels[wheel] / self.PATCH)
        while self._patches[wheel] < patch:
            self._patches[wheel] += 1
            drawn = float(self._rngs[wheel].exponential(self._share)) if self._share else 0.0
            self._lost[wheel] = min(drawn, self.WORST)
        return self._lost[wheel]

    def roll(self, wheel: int, travel: float) -> None:
        """Tell that a wheel rolled on; either way [m]."""
        self._travels[wheel] += abs(travel)
