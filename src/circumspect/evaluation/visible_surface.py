"""Which part of the true surface a camera could see."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.geometry.voxel_sums import voxel_keys
from circumspect.sensing import DepthNoise, pixel_rays
from circumspect.simulation import RayCaster, Scene

SPACING = 0.005
"""Side of the voxels of which each keeps one visible point [m]."""


def visible_surface(
    scene: Scene,
    camera: PinholeCamera,
    T_map_cameras: Iterable[RigidTransform],
    name: str = "object",
    sensor: DepthNoise | None = None,
    spacing: float = SPACING,
) -> NDArray[np.float64]:
    """Points of one of a scene's surfaces where the rays of a camera without noise end.

    A point counts from the sensor's shortest to its longest range, and as long as the ray does not
    graze the surface so much that nothing comes back.

    Args:
        scene: All that can be seen or can hide the surface.
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
        # Comparisons with NaN, where nothing is hit, are false.
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
