"""The object's outline as it is seen from one place, in plan view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import wrapped

BIN = float(np.radians(1.0))
"""One place of the outline for each bearing of this width, as seen from the eye [rad]."""
PATCH = 0.15
"""Normals are those of the outline within this distance [m]."""
FEWEST = 3
"""A normal needs so many places."""


@dataclass(frozen=True, eq=False)
class Outline:
    """The nearest places of an object for each bearing, as seen from an eye.

    Attributes:
        places_xy: (b, 2) [m] from left to right as the eye sees them, which is the way a robot
            goes that drives with the object on its left; each the mean of its neighbourhood.
        normals_xy: (b, 2) unit normals towards the eye; NaN where the outline has none.
        incidences: (b,) [rad] angles between normal and line of sight.
    """

    places_xy: NDArray[np.float64]
    normals_xy: NDArray[np.float64]
    incidences: NDArray[np.float64]

    @classmethod
    def seen_from(cls, footprint_xy: NDArray[np.float64], eye_xy: NDArray[np.float64]) -> Outline:
        """The outline of a footprint.

        Args:
            footprint_xy: (c, 2) [m] plan-view cells with object, at least one.
            eye_xy: (2,) [m].
        """
        nearest = _nearest_by_bearing(footprint_xy, eye_xy)
        patches = np.array([_patch(nearest, place, eye_xy) for place in nearest])
        places, normals = patches[:, 0], patches[:, 1]
        sight = eye_xy - places
        sight /= np.maximum(np.linalg.norm(sight, axis=1, keepdims=True), 1e-9)
        cosine = np.clip(np.einsum("ij,ij->i", normals, sight), -1, 1)
        return cls(places, normals, np.arccos(cosine))


def _nearest_by_bearing(
    footprint_xy: NDArray[np.float64], eye_xy: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(b, 2) the nearest cell for each bearing, from left to right."""
    offset = footprint_xy - eye_xy
    distance = np.linalg.norm(offset, axis=1)
    ahead = offset.mean(axis=0)
    bearing = np.arctan2(offset[:, 1], offset[:, 0]) - np.arctan2(ahead[1], ahead[0])
    to_the_right = -wrapped(bearing)
    bins = np.round(to_the_right / BIN).astype(np.int64)
    order = np.lexsort((distance, bins))
    first = np.flatnonzero(np.diff(bins[order], prepend=bins[order[0]] - 1))
    return footprint_xy[order[first]]


def _patch(
    places_xy: NDArray[np.float64], place_xy: NDArray[np.float64], eye_xy: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Middle and normal of the outline round a place, by principal component analysis.

    The normal is the direction in which the patch varies least. Of a table top seen from above
    the footprint is filled, but only what is on the outline counts.
    """
    near = places_xy[np.linalg.norm(places_xy - place_xy, axis=1) <= PATCH]
    if len(near) < FEWEST:
        return place_xy, np.full(2, np.nan)
    middle = near.mean(axis=0)
    _, axes = np.linalg.eigh((near - middle).T @ (near - middle))
    normal = axes[:, 0]
    return middle, normal if normal @ (eye_xy - place_xy) >= 0 else -normal
