"""The motion of the camera between two frames, with its uncertainty and its scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class RelativeMotion:
    """Motion between two consecutive frames, from odometry or from a motion model.

    The motion for an odometry scale s = (s_translation, s_rotation) is, to first order,
    T exp(G (s - 1)).

    Attributes:
        T_before_now: (4, 4) T, the motion for a scale of 1, optical frame.
        by_scale: (6, 2) G, its derivative with respect to the scale [rad, m]; zero for a motion
            that does not come from odometry.
        covariance: (6, 6) of right perturbations [rad, m].
        source: "odometry", "constant velocity" or "standing still".
    """

    T_before_now: NDArray[np.floating]
    by_scale: NDArray[np.floating]
    covariance: NDArray[np.floating]
    source: str = "odometry"
