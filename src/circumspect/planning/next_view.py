"""What a planner answers."""

from __future__ import annotations

from dataclasses import dataclass

from circumspect.geometry import PlanarPose


@dataclass(frozen=True)
class NextView:
    """Where to look from next.

    Attributes:
        T_map_base: Where the robot should stand.
        looks_at_xy: The place on the object that the camera then looks at [m].
        normal_xy: Outward unit normal of the surface there; None where the planner used none.
        why: How the view was chosen, in words.
    """

    T_map_base: PlanarPose
    looks_at_xy: tuple[float, float]
    normal_xy: tuple[float, float] | None
    why: str


@dataclass(frozen=True)
class Finished:
    """No further view is needed, or none can be had.

    Attributes:
        why: The reason in words.
    """

    why: str
