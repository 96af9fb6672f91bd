"""Whether a frame fits elsewhere just as well."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3
from circumspect.geometry.composition import composed
from circumspect.geometry.pose_distance import distances
from circumspect.mapping.leap import BETTER, LEAST_DISTANCE
from circumspect.mapping.motion import Belief
from circumspect.registration import Registration, RegistrationSettings, Scan, SurfaceMap, register

ASIDE = 3.0
"""A fit is tried from so many reaches of correspondences aside; turns count by what they move at
1 m."""


def is_ambiguous(
    scan: Scan,
    scene: SurfaceMap,
    found: Registration,
    expected: Belief,
    settings: RegistrationSettings,
) -> bool:
    """Whether the prior alone decides between this fit and one aside of it.

    Gauss-Newton's Hessian tells how well the scene holds a frame at its optimum, not whether there
    is another. Along the blank back of a sofa there is one every few centimetres: where the prior
    is weaker than the reach of correspondences, and the scene seems to be stronger, the frame is
    fitted again from both sides in the direction that the scene holds least of these, held loosely
    there. Directions that it does not hold are the prior's anyway.

    Args:
        scan: The frame's points.
        scene: What they were fitted to.
        found: The fit.
        expected: Where the camera was expected.
        settings: How frames are fitted.
    """
    values, vectors = np.linalg.eigh(found.hessian)
    variances = np.einsum("ij,ik,kj->j", vectors, expected.covariance, vectors)
    left = vectors[:, (values > settings.max_distance**-2) & (variances > settings.max_distance**2)]
    if left.shape[1] == 0:
        return False
    step = ASIDE * settings.max_distance * left[:, 0]
    return any(_fits_aside(scan, scene, found, sign * step, settings) for sign in (-1.0, 1.0))


def _fits_aside(
    scan: Scan,
    scene: SurfaceMap,
    found: Registration,
    change: NDArray[np.float64],
    settings: RegistrationSettings,
) -> bool:
    T = composed(found.T_map_camera, se3.exp(change))
    other = register(scan, scene, T, np.eye(6) / settings.max_distance**2, settings)
    apart, _ = distances(other.T_map_camera.as_matrix(), found.T_map_camera.as_matrix())
    as_well = BETTER * other.distance < max(found.distance, LEAST_DISTANCE)
    return bool(apart > settings.max_distance and as_well)
