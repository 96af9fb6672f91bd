"""Whether a registration is to be believed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.mapping.pose_estimator import GATE_OPEN
from circumspect.mapping.registration import Registration


@dataclass(frozen=True)
class GateSettings:
    """When the gate closes.

    Attributes:
        fewest_inliers: Fewer points than this support nothing.
        least_overlap: Share of the scan that must lie on what is known.
        largest_misfit: In standard deviations of the noise, root mean square.
        weakest: The scene must hold every direction to this standard deviation [m]; turns count
            by what they move at 1 m.
        farthest: Squared Mahalanobis distance to the prior; 38 is passed by chance once in a
            million frames (six degrees of freedom).
    """

    fewest_inliers: int = 200
    least_overlap: float = 0.35
    largest_misfit: float = 2.5
    weakest: float = 0.03
    farthest: float = 38.0

    def verdict(self, found: Registration, prior_information: NDArray[np.float64]) -> str:
        """ "open", or the reason why the registration is not to be believed.

        Args:
            found: The registration.
            prior_information: (6, 6) that it was given.
        """
        if found.inliers < self.fewest_inliers:
            return f"{found.inliers} inliers; {self.fewest_inliers} are needed"
        if found.overlap < self.least_overlap:
            return (
                f"{found.overlap:.0%} of the frame lie on what is known; "
                f"{self.least_overlap:.0%} are needed"
            )
        if not found.converged:
            return f"not converged after {found.iterations} steps"
        if found.misfit > self.largest_misfit:
            return f"residual of {found.misfit:.1f} standard deviations ({found.residual:.4f} m)"
        distance = squared_distance(found, prior_information)
        if distance > self.farthest:
            return f"{np.sqrt(distance):.1f} standard deviations from where it was expected"
        weakest = weakest_direction(found.hessian)
        if weakest > self.weakest:
            return f"the scene holds one direction to {weakest:.3f} m only"
        return GATE_OPEN


def weakest_direction(hessian: NDArray[np.float64]) -> float:
    """Standard deviation [m] in the direction that the scene holds least.

    1/√λ for the smallest eigenvalue λ of the Hessian; turns [rad] and shifts [m] are compared
    by what they move at a distance of 1 m.
    """
    smallest = float(np.linalg.eigvalsh(hessian)[0])
    return float(max(smallest, 1e-12) ** -0.5)


def squared_distance(found: Registration, prior_information: NDArray[np.float64]) -> float:
    """Squared Mahalanobis distance of the scan's own optimum to the prior.

    With δ the change from the prior to the joint optimum, H the scan's and Λ the prior's
    information, the scan's own optimum lies at ν = δ + H⁻¹Λδ, and
    νᵀ (Λ⁻¹ + H⁻¹)⁻¹ ν = δᵀΛδ + δᵀΛ H⁻¹ Λδ. Directions that the scan does not hold add nothing.
    """
    pull = prior_information @ found.innovation
    held = np.linalg.pinv(found.hessian, rcond=1e-9, hermitian=True)
    return float(found.innovation @ pull + pull @ held @ pull)
