"""Clusters of a cloud, and outliers far from the rest."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.point_cloud import PointCloud

_LOG = logging.getLogger(__name__)
MIN_POINTS = 100
"""In smaller clouds no point is an outlier."""
MAX_STRAY_SHARE = 0.01
"""Larger groups are a part of the scene, not outliers."""
_MARGIN = 0.25
"""Distance of outliers from the box of 98 % of the points, as a fraction of its diagonal."""
_REACH = 0.1
"""Longest gap within a cluster, in the same unit."""


def connected_clusters(points_xyz: NDArray[np.float64], reach: float) -> NDArray[np.int64]:
    """Cluster points by distance.

    Points are clustered by the cells of a grid of size `reach`: adjacent cells are one cluster, so
    gaps up to about `reach` are bridged, and a million points take little time.

    Args:
        points_xyz: (n, 3), n >= 1.
        reach: The longest gap, in the cloud's unit, positive.

    Returns:
        (n,) number of the cluster of each point, from 0.
    """
    # Its import takes longer than reading most files.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    keys = np.floor((points_xyz - points_xyz.min(axis=0)) / reach).astype(np.int64)
    cells, inverse = np.unique(keys, axis=0, return_inverse=True)
    # Cells that touch, also at a corner, are 1.74 apart at most.
    pairs = KDTree(cells).query_pairs(1.8, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), bool), pairs.T), (len(cells), len(cells)))
    _, labels = connected_components(links, directed=False)
    return labels[inverse.reshape(-1)].astype(np.int64)


def without_stray_points(cloud: PointCloud) -> PointCloud:
    """Remove outliers: single points and small groups far from all others.

    Thin parts of an object, such as the pole of a lamp, stay, since the points along them connect
    their end to the rest. A warning in the log counts the outliers.

    Args:
        cloud: (n, 3) points of one object.

    Returns:
        The cloud without outliers; the same object if there are none.
    """
    points = cloud.points_xyz
    if len(points) < MIN_POINTS:
        return cloud
    low, high = np.quantile(points, [0.01, 0.99], axis=0, method="nearest")
    diagonal = float(np.linalg.norm(high - low))
    margin = _MARGIN * diagonal
    outside = ((points < low - margin) | (points > high + margin)).any(axis=1)
    if not diagonal > 0 or not 0 < outside.sum() <= MAX_STRAY_SHARE * len(points):
        return cloud
    # The distance of an outlier does not matter: it is moved near, so that the cells stay
    # countable.
    near = np.clip(points, low - 2 * diagonal, high + 2 * diagonal)
    clusters = connected_clusters(near, _REACH * diagonal)
    main = np.bincount(clusters).argmax()
    strays = outside & (clusters != main)
    if not (count := int(strays.sum())):
        return cloud
    _LOG.warning("ignored %d of %d points far from all others", count, len(points))
    return cloud.part(~strays)
