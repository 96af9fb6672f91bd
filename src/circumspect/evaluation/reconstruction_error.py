"""How far a model's shape is from the true surface.

The measures are the usual ones of reconstruction (accuracy, completion, chamfer distance, and
completeness at a threshold), taken over what the camera could see: no robot models an underside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import TriangleMesh

THRESHOLD = 0.010
"""A visible point is modelled when the model has a point this near [m].

1 % of a metre, as F-scores of objects are commonly told at 1 % of the object's side; two to eight
standard deviations of the depth at the distances the robot keeps.
"""
SAMPLES_PER_M2 = 40_000
MOST_SAMPLES = 400_000
CANDIDATES = 6
"""So many samples' triangles are tried for the nearest one."""


@dataclass(frozen=True)
class ReconstructionError:
    """Differences between model and true surface.

    Attributes:
        model_points: How many points the model has.
        visible_points: How many points of the true surface it was compared with.
        chamfer_m: Mean of `accuracy_m` and `completion_m`.
        accuracy_m: Mean distance from the model's points to the true surface.
        completion_m: Mean distance from visible points of the true surface to the model's nearest
            point; of a perfect model of points at distances s still about 0.4 s.
        completeness: Share of those within `threshold_m`.
        threshold_m: See there.
    """

    model_points: int
    visible_points: int
    chamfer_m: float
    accuracy_m: float
    completion_m: float
    completeness: float
    threshold_m: float


def reconstruction_error(
    model_xyz: NDArray[np.float64],
    surface: TriangleMesh,
    visible_xyz: NDArray[np.float64],
    threshold: float = THRESHOLD,
) -> ReconstructionError:
    """Compare a model with the surface it stands for.

    Args:
        model_xyz: (n, 3) [m] the model's points, in the frame of the surface.
        surface: The true surface [m].
        visible_xyz: (m, 3) [m] points of it that could be seen, see `visible_surface`.
        threshold: How near a model's point must be to a visible one [m].

    Raises:
        GeometryError: The model is empty or not finite, or nothing was visible.
        InputError: The threshold is not positive.
    """
    from scipy.spatial import KDTree

    if not threshold > 0:
        raise InputError(f"the threshold of completeness must be positive, not {threshold} m")
    model = _points(model_xyz, "the model")
    visible = _points(visible_xyz, "the visible part of the true surface")
    gaps = KDTree(model).query(visible)[0]
    accuracy = float(surface_distances(model, surface).mean())
    completion = float(gaps.mean())
    return ReconstructionError(
        model_points=len(model),
        visible_points=len(visible),
        chamfer_m=(accuracy + completion) / 2,
        accuracy_m=accuracy,
        completion_m=completion,
        completeness=float((gaps <= threshold).mean()),
        threshold_m=threshold,
    )


def surface_distances(
    points_xyz: NDArray[np.float64], surface: TriangleMesh
) -> NDArray[np.float64]:
    """Distance of each point to the nearest triangle.

    The triangles of the nearest few of many samples are tried, each exactly; so a distance is
    never too small, and too large by far less than the samples' spacing.

    Args:
        points_xyz: (n, 3) [m].
        surface: The triangles [m].

    Returns:
        (n,) [m].
    """
    from scipy.spatial import KDTree
    from trimesh.triangles import closest_point

    wanted = float(surface.areas.sum()) * SAMPLES_PER_M2
    count = int(np.clip(wanted, 4 * CANDIDATES + len(surface.faces), MOST_SAMPLES))
    # The same seed draws the same triangles.
    faces, samples = surface.chosen_by_area(count, 0), surface.sampled(count, 0).points_xyz
    _, near = KDTree(samples).query(points_xyz, CANDIDATES)
    best = np.full(len(points_xyz), np.inf)
    for column in faces[near].T:
        nearest = closest_point(surface.corners_xyz[column], points_xyz)
        best = np.minimum(best, np.linalg.norm(nearest - points_xyz, axis=1))
    return best


def _points(points_xyz: NDArray[np.float64], what: str) -> NDArray[np.float64]:
    points = np.asarray(points_xyz, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise GeometryError(f"points of {what} must have shape (n, 3), not {points.shape}")
    if len(points) == 0:
        raise GeometryError(f"{what} has no points; there is nothing to compare")
    if not np.isfinite(points).all():
        raise GeometryError(f"{what} holds NaN or infinite coordinates")
    return points
