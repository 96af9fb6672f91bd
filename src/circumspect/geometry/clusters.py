"""Which points of a cloud hang together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def connected_clusters(points_xyz: NDArray[np.float64], reach: float) -> NDArray[np.int64]:
    """Group points that chains of short steps join.

    Points are joined by the cells of a grid of that size: cells that touch are one cluster, so
    that gaps up to about `reach` are bridged, and a million points cost little.

    Args:
        points_xyz: (n, 3), n >= 1.
        reach: The longest step, in the cloud's unit, positive.

    Returns:
        (n,) number of the cluster of each point, from 0.
    """
    # To load them takes longer than to read most files.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    keys = np.floor((points_xyz - points_xyz.min(axis=0)) / reach).astype(np.int64)
    cells, inverse = np.unique(keys, axis=0, return_inverse=True)
    # Cells that touch, at a corner as well, are 1.74 apart at most.
    pairs = KDTree(cells).query_pairs(1.8, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), bool), pairs.T), (len(cells), len(cells)))
    _, labels = connected_components(links, directed=False)
    return labels[inverse.reshape(-1)].astype(np.int64)
