"""The point-to-plane problem, linear about one pose."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from circumspect.mapping.scan import Scan
from circumspect.mapping.scan_surface import FLOOR
from circumspect.mapping.scene_map import SceneMap

TUKEY = 4.685
"""Residuals of so many standard deviations have no say (95 % efficiency on normal noise)."""
LEAST_SPREAD = 0.2
"""The noise is never taken for less than this share of what the sensor's description says."""
STANDING = 100
"""So many points off the floor are enough to tell the overlap by them alone."""
FAR = 0.02
"""A point this far [m] from the map's planes or further just does not fit."""
AVERTED = 0.1
"""Surfaces whose normals make a larger cosine than this with the line of sight show their back,
which no camera sees: the far side of a thin board is not taken for the near one."""
FEWEST = 6
"""Correspondences without which there is nothing to solve."""
FEIGNED = 3.0
"""So many times what noise of the normals feigns is taken off the information."""
RIDGE = 1.0
"""Information [1/m², 1/rad²] that means nothing."""


@dataclass(frozen=True)
class Weighing:
    """What residuals count for.

    Attributes:
        correlation: So many points count as one independent measurement; see docs/derivations.md
            for how it is measured.
        uneven: A plane is off by so many times the variance that points have across it, beside
            the sensor's noise.
        least_cut: What is less than so many `TUKEY` of the sensor's standard deviations off is
            no outlier.
    """

    correlation: float
    uneven: float
    least_cut: float


FINDING = Weighing(correlation=14.0, uneven=0.0, least_cut=1.0)
"""While the way is being found: rims show where to, and what is far off is no outlier yet."""
TELLING = Weighing(correlation=4.0, uneven=3.0, least_cut=0.0)
"""At the optimum and for what is told of it: rims, whose planes are of both their sides, are off
by far more than noise."""


@dataclass(frozen=True, eq=False)
class LinearFit:
    """The point-to-plane problem, linear about one pose.

    Attributes:
        hessian, gradient: (6, 6) and (6,) of half the sum of weighted squares.
        feigned: (6, 6) what noise of the normals is expected to add to the Hessian.
        inliers, overlap, distance, residual, misfit: See `Registration`.
    """

    hessian: NDArray[np.float64] = field(default_factory=lambda: np.zeros((6, 6)))
    feigned: NDArray[np.float64] = field(default_factory=lambda: np.zeros((6, 6)))
    gradient: NDArray[np.float64] = field(default_factory=lambda: np.zeros(6))
    inliers: int = 0
    overlap: float = 0.0
    distance: float = FAR
    residual: float = 0.0
    misfit: float = 0.0

    def believable(self) -> LinearFit:
        """The problem without what noise of the normals feigns.

        On a bare wall the normals' noise pretends to a texture, and with it to information
        along the wall. With H the Hessian and S what is feigned, directions v in which
        H v = λ S v keep λ - `FEIGNED` of λ, and those with less nothing: there the prior
        decides alone (after Zhang, Kaess and Singh, "On degeneracy of optimization-based state
        estimation problems", 2016, whose threshold is a constant).
        """
        S = self.feigned + RIDGE * np.eye(6)
        values, W = eigh(self.hessian, S, check_finite=False)  # Wᵀ S W = I
        kept = np.maximum(values - FEIGNED, 0.0)
        V = S @ W
        share = kept / np.maximum(values, FEIGNED)
        gradient = V @ (share * (W.T @ self.gradient))
        return replace(self, hessian=(V * kept) @ V.T, gradient=gradient)


def linearised(
    scan: Scan,
    scene: SceneMap,
    T: NDArray[np.float64],
    reach: float,
    weighing: Weighing = TELLING,
) -> LinearFit:
    """The point-to-plane problem about one pose, in C++; its twin is in `numpy_twin`.

    Args:
        scan: The frame's points.
        scene: What they are compared with.
        T: (4, 4) `T_map_camera`.
        reach: Points further than this [m] from the map have no correspondence.
        weighing: What residuals count for.
    """
    if len(scan) == 0 or len(scene) == 0:
        return LinearFit()
    return LinearFit(
        *scene.planes.linearised(
            scan.points_xyz,
            scan.sigmas,
            T,
            reach=reach,
            tukey=TUKEY,
            correlation=weighing.correlation,
            uneven=weighing.uneven,
            least_cut=weighing.least_cut,
            least_spread=LEAST_SPREAD,
            floor=FLOOR,
            far=FAR,
            averted=AVERTED,
            standing=STANDING,
            fewest=FEWEST,
        )
    )
