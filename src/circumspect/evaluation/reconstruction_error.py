"""Distance of a model's shape from the part of the true surface that a camera could see.

The measures are the usual ones (accuracy, completion, chamfer distance, and completeness at a
threshold), restricted to what the camera could see, since no robot can model an underside.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.geometry.voxel_sums import voxel_keys
from circumspect.sensing import DepthNoise, pixel_rays
from circumspect.simulation import RayCaster, Scene

THRESHOLD = 0.010
"""A visible point counts as modelled if the model has a point this near [m].

This is 1 % of a metre, as F-scores of objects commonly use 1 % of the object's side, and two to
eight standard deviations of the depth at the robot's distances.
"""
SAMPLES_PER_M2 = 40_000
MAX_SAMPLES = 400_000
CANDIDATES = 6
"""Number of nearest samples whose triangles are tried."""
SPACING = 0.005
"""Side of the voxels that keep one visible point each [m]."""


@dataclass(frozen=True)
class ReconstructionError:
    """Differences between model and true surface.

    Attributes:
        model_points: Number of points of the model.
        visible_points: Number of visible points of the true surface.
        chamfer_m: Mean of `accuracy_m` and `completion_m`.
        accuracy_m: Mean distance from the model's points to the true surface.
        completion_m: Mean distance from visible points of the true surface to the model's nearest
            point; of a perfect model of points at distances s still about 0.4 s.
        completeness: Share of those within `threshold_m`.
        threshold_m: See there.
        whole_completeness: The same share of the whole true surface by area, undersides and hidden
            parts included.
    """

    model_points: int
    visible_points: int
    chamfer_m: float
    accuracy_m: float
    completion_m: float
    completeness: float
    threshold_m: float
    whole_completeness: float


def reconstruction_error(
    model_xyz: NDArray[np.float64],
    surface: TriangleMesh,
    visible_xyz: NDArray[np.float64],
    threshold: float = THRESHOLD,
) -> ReconstructionError:
    """Compare a model with the true surface.

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
    tree = KDTree(model)
    gaps = tree.query(visible)[0]
    whole = surface.sampled(_sample_count(surface), 0).points_xyz
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
        whole_completeness=float((tree.query(whole)[0] <= threshold).mean()),
    )


def surface_distances(
    points_xyz: NDArray[np.float64], surface: TriangleMesh
) -> NDArray[np.float64]:
    """Distance of each point to the nearest triangle.

    The triangles of the nearest few of many samples are tried, each exactly. A distance is never
    too small, and too large by far less than the samples' spacing.

    Args:
        points_xyz: (n, 3) [m].
        surface: The triangles [m].

    Returns:
        (n,) [m].
    """
    from scipy.spatial import KDTree
    from trimesh.triangles import closest_point

    count = _sample_count(surface)
    # The same seed draws the same triangles.
    faces, samples = surface.chosen_by_area(count, 0), surface.sampled(count, 0).points_xyz
    _, near = KDTree(samples).query(points_xyz, CANDIDATES)
    best = np.full(len(points_xyz), np.inf)
    for column in faces[near].T:
        nearest = closest_point(surface.corners_xyz[column], points_xyz)
        best = np.minimum(best, np.linalg.norm(nearest - points_xyz, axis=1))
    return best


def _sample_count(surface: TriangleMesh) -> int:
    wanted = float(surface.areas.sum()) * SAMPLES_PER_M2
    return int(np.clip(wanted, 4 * CANDIDATES + len(surface.faces), MAX_SAMPLES))


def _points(points_xyz: NDArray[np.float64], what: str) -> NDArray[np.float64]:
    points = np.asarray(points_xyz, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise GeometryError(f"points of {what} must have shape (n, 3), not {points.shape}")
    if len(points) == 0:
        raise GeometryError(f"{what} has no points; there is nothing to compare")
    if not np.isfinite(points).all():
        raise GeometryError(f"{what} holds NaN or infinite coordinates")
    return points


def visible_surface(
    scene: Scene,
    camera: PinholeCamera,
    T_map_cameras: Iterable[RigidTransform],
    name: str = "object",
    sensor: DepthNoise | None = None,
    spacing: float = SPACING,
) -> NDArray[np.float64]:
    """Points of one of a scene's surfaces where the rays of a camera without noise end.

    A point counts within the sensor's range, unless the ray grazes the surface so much that no
    depth is measured.

    Args:
        scene: Everything that can be seen or can occlude the surface.
        camera: The camera.
        T_map_cameras: Its true poses.
        name: Of the surface.
        sensor: Gives range and steepest incidence.
        spacing: Of the points: one in each voxel of this side [m].

    Returns:
        (n, 3) [m] in the scene's frame, exactly on the surface, spread evenly; may be empty.

    Raises:
        InputError: The scene has no such surface.
        MissingExtraError: Embree is not installed.
    """
    names = [surface.name for surface in scene.surfaces]
    if name not in names:
        raise InputError(f"no surface '{name}' in the scene; known: {', '.join(names)}")
    wanted = [index for index, other in enumerate(names) if other == name]
    sensor = sensor or DepthNoise()
    caster, seen = RayCaster(scene), np.empty((0, 3))
    for T_map_camera in T_map_cameras:
        view = caster.view(camera, T_map_camera)
        # Comparisons with NaN, for rays without a hit, are false.
        mask = (view.depth >= sensor.nearest) & (view.depth <= sensor.farthest)
        mask &= np.isin(view.surface, wanted) & (view.incidence <= sensor.steepest_incidence)
        points = pixel_rays(camera)[mask] * view.depth[mask][:, None]
        seen = _thinned(np.concatenate([seen, T_map_camera.apply(points)]), spacing)
    return seen


def _thinned(points_xyz: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
    """The first point of each voxel; not their mean, which may lie beside a curved surface."""
    # Faces at round coordinates must not lie between two layers of voxels.
    keys = voxel_keys(points_xyz + spacing * np.array([0.37, 0.59, 0.43]), spacing)
    return points_xyz[np.unique(keys, return_index=True)[1]]
