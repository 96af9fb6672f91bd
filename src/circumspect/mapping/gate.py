"""Whether a registration is to be believed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.registration import Registration

GATE_OPEN = "open"


@dataclass(frozen=True)
class Verdict:
    """What the gate says.

    Attributes:
        reason: "open", or why the registration is not to be believed.
        contradicts: The frame does not show what it should from there: the belief itself is in
            doubt.
        mute: The frame says nothing: it neither supports the belief nor contradicts. One that is
            not open, but neither of both, agrees as far as it says something.
    """

    reason: str = GATE_OPEN
    contradicts: bool = False
    mute: bool = False

    @property
    def is_open(self) -> bool:
        """Whether the registration is believed."""
        return self.reason == GATE_OPEN


@dataclass(frozen=True)
class GateSettings:
    """When the gate closes.

    Attributes:
        fewest_points: A frame with fewer says nothing.
        fewest_inliers: Fewer points than this support nothing.
        least_overlap: Share of the scan that must lie on what is known.
        largest_misfit: In standard deviations of the noise, root mean square.
        most_through: Share of the known surface in view that the frame may look through.
        weakest: The scene must hold every direction to this standard deviation [m]; turns count
            by what they move at 1 m.
        farthest: Squared Mahalanobis distance to the prior; 38 is passed by chance once in a
            million frames (six degrees of freedom).
    """

    fewest_points: int = 300
    fewest_inliers: int = 200
    least_overlap: float = 0.35
    largest_misfit: float = 2.5
    most_through: float = 0.04
    weakest: float = 0.03
    farthest: float = 38.0

    def verdict(
        self,
        found: Registration,
        prior_information: NDArray[np.floating],
        through: float = 0.0,
        least_overlap: float | None = None,
    ) -> Verdict:
        """Judge a registration.

        Args:
            found: The registration.
            prior_information: (6, 6) that it was given.
            through: Share of the map in view that the frame looks through; see `violation_ratio`.
            least_overlap: In place of the settings'.
        """
        least = self.least_overlap if least_overlap is None else least_overlap
        if found.points < self.fewest_points:
            return Verdict(
                f"{found.points} points in range; {self.fewest_points} are needed", mute=True
            )
        if found.inliers < self.fewest_inliers:
            return Verdict(f"{found.inliers} inliers; {self.fewest_inliers} are needed", True)
        if found.overlap < least:
            return Verdict(
                f"{found.overlap:.0%} of the frame lie on what is known; {least:.0%} are needed",
                True,
            )
        if through > self.most_through:
            return Verdict(f"looks through {through:.0%} of what is known to be there", True)
        if found.normalised_residual > self.largest_misfit:
            return Verdict(f"residual of {found.normalised_residual:.1f} standard deviations", True)
        distance = squared_distance(found, prior_information)
        if distance > self.farthest:
            return Verdict(
                f"{np.sqrt(distance):.1f} standard deviations from where it was expected", True
            )
        if not found.converged:
            return Verdict(f"not converged after {found.iterations} steps", mute=True)
        weakest = weakest_direction(found.hessian)
        if weakest > self.weakest:
            return Verdict(self._freedom(weakest))
        return Verdict()

    def _freedom(self, weakest: float) -> str:
        if weakest > 1.0:  # a metre and more is no hold at all
            return "the scene leaves one direction free"
        return f"the scene holds one direction to {weakest:.3f} m; {self.weakest:g} m are needed"


def weakest_direction(hessian: NDArray[np.float64]) -> float:
    """Standard deviation [m] in the direction that the scene holds least.

    1/√λ for the smallest eigenvalue λ of the Hessian; turns [rad] and shifts [m] are compared
    by what they move at a distance of 1 m.
    """
    smallest = float(np.linalg.eigvalsh(hessian)[0])
    return float(max(smallest, 1e-6) ** -0.5)


def squared_distance(found: Registration, prior_information: NDArray[np.floating]) -> float:
    """Squared Mahalanobis distance of the scan's own optimum to the prior.

    With δ the change from the prior to the joint optimum, H the scan's and Λ the prior's
    information, the scan's own optimum lies at ν = δ + H⁻¹Λδ, and
    νᵀ (Λ⁻¹ + H⁻¹)⁻¹ ν = δᵀΛδ + δᵀΛ H⁻¹ Λδ. Directions that the scan does not hold add nothing.
    """
    pull = prior_information @ found.innovation
    held = np.linalg.pinv(found.hessian, rcond=1e-9, hermitian=True)
    return float(found.innovation @ pull + pull @ held @ pull)
