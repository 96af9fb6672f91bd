"""The paper's rule: face the surface perpendicularly where the seen part ends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose, wrapped
from circumspect.planning.base_pose import (
    SURFACE_DISTANCE_M,
    base_pose,
    camera_place,
    fitting_distance,
)
from circumspect.planning.circle_planner import (
    NOTHING_KNOWN,
    circle_view,
    require_step,
    view_beyond,
)
from circumspect.planning.orbit_coverage import camera_bearing
from circumspect.planning.planner_input import Finished, NextView, PlannerInput
from circumspect.planning.view_planner import ViewPlanner

MAX_INCIDENCE_RAD = float(np.radians(70.0))
"""Maximum angle to the normal at which a surface counts as seen [rad]."""
MAX_BACKWARD_TURN_RAD = float(np.radians(25.0))
"""A normal that turns backwards by more than this points into a corner [rad]."""
MAX_EXTRA_DISTANCE_M = 1.0
"""A normal along which a view must be moved out by more than this points into a corner [m]."""
DISTANCE_TOLERANCE_M = 0.03
"""Tolerance of the distance between a view and any part of the object [m]."""
BIN_RAD = float(np.radians(1.0))
"""Width of the bearings of the outline [rad]."""
PATCH_RADIUS_M = 0.15
"""Radius of the patch that determines a normal [m]."""
MIN_PATCH_PLACES = 3
"""Minimum number of points for a normal."""


@dataclass(frozen=True, eq=False)
class Outline:
    """Nearest points of an object in each bearing, as seen from a position.

    Attributes:
        places_xy: (b, 2) from left to right [m], the driving direction with the object on the left;
            each is the mean of its neighbourhood.
        normals_xy: (b, 2) unit normals towards the position; NaN where there is none.
        incidences: (b,) angles between normal and line of sight [rad].
    """

    places_xy: NDArray[np.float64]
    normals_xy: NDArray[np.float64]
    incidences: NDArray[np.float64]

    @classmethod
    def seen_from(cls, footprint_xy: NDArray[np.float64], eye_xy: NDArray[np.float64]) -> Outline:
        """Compute the outline of a footprint.

        Args:
            footprint_xy: (c, 2) plan-view cells of the object [m], at least one.
            eye_xy: (2,) position of the observer [m].
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
    """(b, 2) nearest cell in each bearing, from left to right."""
    offset = footprint_xy - eye_xy
    distance = np.linalg.norm(offset, axis=1)
    ahead = offset.mean(axis=0)
    bearing = np.arctan2(offset[:, 1], offset[:, 0]) - np.arctan2(ahead[1], ahead[0])
    to_the_right = -wrapped(bearing)
    bins = np.round(to_the_right / BIN_RAD).astype(np.int64)
    order = np.lexsort((distance, bins))
    first = np.flatnonzero(np.diff(bins[order], prepend=bins[order[0]] - 1))
    return footprint_xy[order[first]]


def _patch(
    places_xy: NDArray[np.float64], place_xy: NDArray[np.float64], eye_xy: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centre and normal of the outline around a point, by principal component analysis.

    The normal is the direction of smallest variance. The footprint of a table top is filled, but
    only points on the outline are used.
    """
    near = places_xy[np.linalg.norm(places_xy - place_xy, axis=1) <= PATCH_RADIUS_M]
    if len(near) < MIN_PATCH_PLACES:
        return place_xy, np.full(2, np.nan)
    middle = near.mean(axis=0)
    _, axes = np.linalg.eigh((near - middle).T @ (near - middle))
    normal = axes[:, 0]
    return middle, normal if normal @ (eye_xy - place_xy) >= 0 else -normal


@dataclass(frozen=True)
class SurfaceNormalPlanner(ViewPlanner):
    """Section 3.1: the next view is `distance` along the normal at the leading edge.

    The leading edge is where the visible surface ends in the driving direction, counter-clockwise
    seen from above. Its normal comes from principal component analysis. If that view is no
    progress, as at a corner whose next side is not seen yet, the view is turned round the edge.

    Attributes:
        distance: Horizontal distance between camera and surface if the object fits the image [m].
        corner_deg: Turn of a view at a corner [degrees].
        min_turn_deg: Minimum progress of a view [degrees].
        max_turn_deg: Maximum angle between two views, from the object's centre [degrees].

    Raises:
        InputError: `corner_deg` or `min_turn_deg` is outside 5 … 90 degrees.
    """

    distance: float = SURFACE_DISTANCE_M
    corner_deg: float = 30.0
    min_turn_deg: float = 8.0
    max_turn_deg: float = 75.0

    def __post_init__(self) -> None:
        for name in ("corner_deg", "min_turn_deg"):
            require_step(name, getattr(self, name))

    def next_view(self, planner_input: PlannerInput) -> NextView | Finished:
        """See `ViewPlanner.next_view`; after unreachable views it moves on a circle."""
        if len(planner_input.points_xyz) == 0:
            return Finished(NOTHING_KNOWN)
        if (done := self.check_finished(planner_input)) is not None:
            return done
        if planner_input.unreachable:
            return view_beyond(planner_input, float(np.radians(self.corner_deg)), self.distance)
        eye = camera_place(planner_input.T_map_base, planner_input.T_base_camera)
        outline = Outline.seen_from(planner_input.footprint_xy, eye.xy)
        for edge, normal, reason in self._candidates(outline, eye):
            view = self._view(planner_input, edge, normal, reason)
            if view is not None and self._advances(planner_input, view):
                return view
        return circle_view(planner_input, float(np.radians(self.corner_deg)), self.distance)

    def _candidates(
        self, outline: Outline, eye: PlanarPose
    ) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], str]]:
        """Edges and directions of view, in order of preference."""
        with np.errstate(invalid="ignore"):
            faced = np.flatnonzero(outline.incidences <= MAX_INCIDENCE_RAD)
        last = int(faced[-1]) if len(faced) else len(outline.places_xy) - 1
        edge, ahead = outline.places_xy[last], _unit(eye.xy - outline.places_xy[last])
        if len(faced):
            normal = outline.normals_xy[last]
            if _turn(-eye.heading_xy, normal) > -MAX_BACKWARD_TURN_RAD:
                yield edge, normal, "along the normal at the leading edge"
            # Turn whichever of the normal and the line of sight is further round.
            ahead = normal if _turn(ahead, normal) > 0 else ahead
        turned = _turned(ahead, np.radians(self.corner_deg))
        yield edge, turned, f"turned {self.corner_deg:.0f}° round the edge"

    def _view(
        self,
        planner_input: PlannerInput,
        edge_xy: NDArray[np.float64],
        normal_xy: NDArray[np.float64],
        reason: str,
    ) -> NextView | None:
        """The view of an edge along a normal at a sufficient distance from the whole object.

        None where the normal points into a corner.
        """
        flat = planner_input.footprint_xy
        fitting = fitting_distance(planner_input, normal_xy, self.distance)
        for away in np.arange(fitting, fitting + MAX_EXTRA_DISTANCE_M, 0.05):
            place_xy = edge_xy + away * normal_xy
            if (
                np.linalg.norm(flat - place_xy, axis=1).min()
                >= self.distance - DISTANCE_TOLERANCE_M
            ):
                break
        else:
            return None
        place = base_pose(place_xy, edge_xy, planner_input.T_base_camera)
        looks_at, normal = ((float(vector[0]), float(vector[1])) for vector in (edge_xy, normal_xy))
        return NextView(place, looks_at, normal, f"{reason}, {away:.2f} m away")

    def _advances(self, planner_input: PlannerInput, view: NextView) -> bool:
        """Whether a view is further round the object, but not too far."""
        poses = (planner_input.T_map_base, view.T_map_base)
        here, there = (camera_bearing(planner_input, pose) for pose in poses)
        turn = np.degrees(wrapped(there - here))
        return bool(self.min_turn_deg <= turn <= self.max_turn_deg)


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / max(float(np.linalg.norm(vector)), 1e-9)


def _turn(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Angle from the first to the second unit vector [rad], counter-clockwise, -π … π."""
    cross = first[0] * second[1] - first[1] * second[0]
    return float(np.arctan2(cross, first @ second))


def _turned(vector: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
