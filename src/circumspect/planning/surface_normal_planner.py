"""The paper's rule: look perpendicularly at the surface where what was seen of it ends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose, wrapped
from circumspect.planning.circle_planner import (
    NOTHING_KNOWN,
    beyond,
    circle_view,
    require_step,
)
from circumspect.planning.next_view import Finished, NextView
from circumspect.planning.outline import Outline
from circumspect.planning.rounds import camera_bearing
from circumspect.planning.situation import Situation
from circumspect.planning.stance import (
    SURFACE_DISTANCE,
    camera_place,
    fitting_distance,
    stance,
)
from circumspect.planning.view_planner import ViewPlanner

STEEPEST = float(np.radians(70.0))
"""Surface seen at a larger angle to its normal than this is not taken as seen [rad]."""
MOST_BACK = float(np.radians(25.0))
"""A normal that turns back by more than this, seen from here, points into a corner [rad]."""
FURTHER_OUT = 1.0
"""A normal points into a corner where a view has to be moved out by this to be clear [m]."""
CLOSE_ENOUGH = 0.03
"""Nothing of the object may be nearer to a view than the wanted distance less this [m]."""


@dataclass(frozen=True)
class SurfaceNormalPlanner(ViewPlanner):
    """Section 3.1: the next view is `distance` along the normal at the leading edge.

    The leading edge is where the surface seen from here ends in the driving direction,
    counter-clockwise as seen from above; its normal comes from principal component analysis.
    Where that leads no further - at a corner, where the next side is not seen yet - the view is
    turned round the edge.

    Attributes:
        distance: Level distance of camera and surface where the object fits the image [m].
        corner_deg: By how much a view is turned at a corner [degrees].
        least_deg: A view that is less than this further round leads no further [degrees].
        most_deg: Views are at most this far apart, as seen from the object's centre [degrees].

    Raises:
        InputError: `corner_deg` or `least_deg` is outside of 5 … 90 degrees.
    """

    distance: float = SURFACE_DISTANCE
    corner_deg: float = 30.0
    least_deg: float = 8.0
    most_deg: float = 75.0

    def __post_init__(self) -> None:
        for name in ("corner_deg", "least_deg"):
            require_step(name, getattr(self, name))

    def next_view(self, situation: Situation) -> NextView | Finished:
        """See `ViewPlanner.next_view`; beyond views that can not be reached a circle is driven."""
        if len(situation.points_xyz) == 0:
            return Finished(NOTHING_KNOWN)
        if (done := self.enough(situation)) is not None:
            return done
        if situation.unreachable:
            return beyond(situation, float(np.radians(self.corner_deg)), self.distance)
        eye = camera_place(situation.T_map_base, situation.T_base_camera)
        outline = Outline.seen_from(situation.footprint_xy, eye.xy)
        for edge, normal, why in self._candidates(outline, eye):
            view = self._view(situation, edge, normal, why)
            if view is not None and self._leads_on(situation, view):
                return view
        return circle_view(situation, float(np.radians(self.corner_deg)), self.distance)

    def _candidates(
        self, outline: Outline, eye: PlanarPose
    ) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], str]]:
        """Edges and directions to look from, the wanted one first."""
        with np.errstate(invalid="ignore"):
            faced = np.flatnonzero(outline.incidences <= STEEPEST)
        last = int(faced[-1]) if len(faced) else len(outline.places_xy) - 1
        edge, ahead = outline.places_xy[last], _unit(eye.xy - outline.places_xy[last])
        if len(faced):
            normal = outline.normals_xy[last]
            if _turn(-eye.heading_xy, normal) > -MOST_BACK:
                yield edge, normal, "along the normal at the leading edge"
            # Whichever of the normal and the line of sight is further round is turned on.
            ahead = normal if _turn(ahead, normal) > 0 else ahead
        turned = _turned(ahead, np.radians(self.corner_deg))
        yield edge, turned, f"turned {self.corner_deg:.0f}° round the edge"

    def _view(
        self,
        situation: Situation,
        edge_xy: NDArray[np.float64],
        normal_xy: NDArray[np.float64],
        why: str,
    ) -> NextView | None:
        """The view of an edge along a normal, with all of the object far enough away.

        None where the normal points into a corner.
        """
        flat = situation.footprint_xy
        fitting = fitting_distance(situation, normal_xy, self.distance)
        for away in np.arange(fitting, fitting + FURTHER_OUT, 0.05):
            place_xy = edge_xy + away * normal_xy
            if np.linalg.norm(flat - place_xy, axis=1).min() >= self.distance - CLOSE_ENOUGH:
                break
        else:
            return None
        place = stance(place_xy, edge_xy, situation.T_base_camera)
        looks_at, normal = ((float(vector[0]), float(vector[1])) for vector in (edge_xy, normal_xy))
        return NextView(place, looks_at, normal, f"{why}, {away:.2f} m away")

    def _leads_on(self, situation: Situation, view: NextView) -> bool:
        """Whether a view is further round the object, and not too far."""
        poses = (situation.T_map_base, view.T_map_base)
        here, there = (camera_bearing(situation, pose) for pose in poses)
        turn = np.degrees(wrapped(there - here))
        return bool(self.least_deg <= turn <= self.most_deg)


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / max(float(np.linalg.norm(vector)), 1e-9)


def _turn(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Angle from the first to the second unit vector [rad], counter-clockwise, -π … π."""
    cross = first[0] * second[1] - first[1] * second[0]
    return float(np.arctan2(cross, first @ second))


def _turned(vector: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
