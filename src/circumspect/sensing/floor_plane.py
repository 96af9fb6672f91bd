"""The floor in a frame whose pose is roughly known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SETTLED = 1e-5
"""Iterations end once slopes and height [m] change less."""
BAND = 0.06
"""So far from where the floor should be it is looked for [m]."""
FEWEST = 200
"""Points that make a floor."""


@dataclass(frozen=True)
class FloorPlane:
    """z = slope_x x + slope_y y + offset in the map frame.

    Attributes:
        slope_x, slope_y: rise per metre.
        offset: height at the origin [m].
    """

    slope_x: float = 0.0
    slope_y: float = 0.0
    offset: float = 0.0

    def heights(self, points_xyz: NDArray[np.floating]) -> NDArray[np.floating]:
        """(n,) [m]: vertical distance of (n, 3) points above the floor."""
        x, y, z = points_xyz[:, 0], points_xyz[:, 1], points_xyz[:, 2]
        return z - self.slope_x * x - self.slope_y * y - self.offset

    def refined(
        self,
        points_xyz: NDArray[np.floating],
        band: float = BAND,
        steepest: float = 0.05,
        fewest: int = FEWEST,
        rounds: int = 6,
    ) -> FloorPlane:
        """Fit to the points near this plane by iteratively reweighted least squares.

        Tukey's weights with the spread taken from the median absolute residual: what stands on
        the floor has no say.

        Args:
            points_xyz: (n, 3) [m] any points of the frame, map frame.
            band: Only points within this distance of the plane are looked at [m].
            steepest: A fit that departs by more than this slope is not believed.
            fewest: With fewer points than this the plane stays as it is.
            rounds: Most iterations.

        Returns:
            The fitted plane; this one where the fit can not be trusted.
        """
        near = points_xyz[np.abs(self.heights(points_xyz)) < band].astype(np.float64)
        if len(near) < fewest:
            return self
        centre = near[:, :2].mean(axis=0)
        design = np.column_stack([near[:, :2] - centre, np.ones(len(near))])
        z, weights = near[:, 2], np.ones(len(near))
        solution = np.full(3, np.inf)
        for _ in range(rounds):
            weighted = design * weights[:, None]
            before = solution
            solution = np.linalg.lstsq(weighted.T @ design, weighted.T @ z, rcond=None)[0]
            if np.abs(solution - before).max() < SETTLED:
                break
            residual = z - design @ solution
            spread = max(1.4826 * float(np.median(np.abs(residual))), 5e-4)
            weights = np.clip(1 - (residual / (4.685 * spread)) ** 2, 0, None) ** 2
        slope_x, slope_y, level = (float(value) for value in solution)
        fitted = FloorPlane(slope_x, slope_y, level - float(solution[:2] @ centre))
        change = np.hypot(slope_x - self.slope_x, slope_y - self.slope_y)
        moved = abs(fitted.offset - self.offset + (solution[:2] - self._slopes) @ centre)
        return fitted if change < steepest and moved < band else self

    @property
    def _slopes(self) -> NDArray[np.float64]:
        return np.array([self.slope_x, self.slope_y])
