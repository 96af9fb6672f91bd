"""Points far from all others: they would set the scale of an object."""

from __future__ import annotations

import logging

import numpy as np

from circumspect.geometry.point_cloud import PointCloud

_LOG = logging.getLogger(__name__)

MIN_POINTS = 100
"""In smaller clouds every point counts."""
MAX_STRAY_SHARE = 0.01
"""More points than this are a part of the scene, not strays."""

_MARGIN = 0.25
"""Strays lie outside of the box of 98 % of the points by more than this share of its diagonal …"""
_REACH = 0.1
"""… and no chain of steps of this length, in the same unit, leads to the others."""


def without_stray_points(cloud: PointCloud) -> PointCloud:
    """Leave out single points and small groups that lie far from all others.

    Thin parts of an object, such as the pole of a lamp, stay: points along them join their end to
    the rest. A warning in the log counts what is ignored.

    Args:
        cloud: (n, 3) points of one object.

    Returns:
        The cloud without strays; the very same one where there are none.
    """
    points = cloud.points_xyz
    if len(points) < MIN_POINTS:
        return cloud
    low, high = np.quantile(points, [0.01, 0.99], axis=0)
    diagonal = float(np.linalg.norm(high - low))
    margin = _MARGIN * diagonal
    outside = ((points < low - margin) | (points > high + margin)).any(axis=1)
    if not diagonal > 0 or not 0 < outside.sum() <= MAX_STRAY_SHARE * len(points):
        return cloud
    from circumspect.geometry.clusters import connected_clusters

    # How far away a stray lies does not matter: it is moved near, so that cells stay countable.
    near = np.clip(points, low - 2 * diagonal, high + 2 * diagonal)
    clusters = connected_clusters(near, _REACH * diagonal)
    main = np.bincount(clusters).argmax()
    strays = outside & (clusters != main)
    if not (count := int(strays.sum())):
        return cloud
    _LOG.warning("ignored %d of %d points far from all others", count, len(points))
    return cloud.part(~strays)
