"""What is learnt later of poses that were not certain when they were told."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3, se3_matrices
from circumspect.geometry.composition import between, orthonormal
from circumspect.mapping.motion import Belief

MOST = 2000
"""A stretch of so many frames is looked back at; of a longer one the first keep what was told."""


class _Step(NamedTuple):
    """From one pose that was not certain to the next.

    Attributes:
        number: Of the first of the two.
        gain: (6, 6) the change of the first by one of the prediction of the second.
        update: (6,) by which the second was told to be off its prediction [rad, m].
    """

    number: int
    gain: NDArray[np.float64]
    update: NDArray[np.float64]


class Hindsight:
    """A Rauch-Tung-Striebel smoother over stretches of poses that were not certain.

    A camera that was led by its wheels alone, or was lost, is known again once a pose is certain.
    What the way there was off by then goes back along it: to each pose the share that its own
    covariance has of what the next one's was predicted to be. Certain poses stay: the graph of the
    keyframes corrects them. (Rauch, Tung and Striebel, "Maximum likelihood estimates of linear
    dynamic systems", 1965.)
    """

    def __init__(self) -> None:
        """Nothing was told yet."""
        self._changes = np.zeros((64, 6))
        self._count = 0
        self._last: int | None = None
        self._steps: deque[_Step] = deque(maxlen=MOST)

    def hear(self, before: Belief, expected: Belief, after: Belief, certain: bool) -> int | None:
        """Take the pose of the next frame.

        Args:
            before: What was believed of the frame before, in the map as it is now.
            expected: What that predicted of this one.
            after: What is told of it.
            certain: Whether it is certain.

        Returns:
            The number by which `seen` knows it; None where it is certain.
        """
        if self._last is not None:
            self._steps.append(_step(self._last, before, expected, after))
        if certain:
            self._look_back()
            self._last = None
        else:
            self._last = self._new_number()
        return self._last

    def seen(self, T_map_camera: RigidTransform, number: int) -> RigidTransform:
        """A pose that was told, by what is known now.

        Args:
            T_map_camera: As it was told.
            number: What `hear` gave for it.
        """
        matrix = T_map_camera.as_matrix() @ se3_matrices.exp(self._changes[number])
        return orthonormal(matrix)

    def _new_number(self) -> int:
        if self._count == len(self._changes):
            self._changes = np.concatenate([self._changes, np.zeros_like(self._changes)])
        self._count += 1
        return self._count - 1

    def _look_back(self) -> None:
        change = np.zeros(6)
        while self._steps:
            number, gain, update = self._steps.pop()
            whole = se3_matrices.exp(update) @ se3_matrices.exp(change)
            change = gain @ se3_matrices.log(whole)
            self._changes[number] = change


def _step(number: int, before: Belief, expected: Belief, after: Belief) -> _Step:
    F = se3.adjoint(between(before.T_map_camera, expected.T_map_camera).inv())
    carried = F @ before.covariance @ F.T
    # What the floor says to a prediction is in it already: no motion makes a pose better known.
    values, vectors = np.linalg.eigh(expected.covariance - carried)
    predicted = carried + (vectors * np.maximum(values, 0.0)) @ vectors.T
    gain = before.covariance @ F.T @ np.linalg.inv(predicted)
    update = se3_matrices.log(between(expected.T_map_camera, after.T_map_camera).as_matrix())
    return _Step(number, gain, update)
