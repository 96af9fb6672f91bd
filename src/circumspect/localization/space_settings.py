"""How the intelligent space weighs and doubts."""

from __future__ import annotations

from dataclasses import dataclass

from circumspect.errors import InputError
from circumspect.localization.tag_pose import COMMON_SIGMA, CORNER_SIGMA


@dataclass(frozen=True)
class SpaceSettings:
    """Of `IntelligentSpace`.

    Attributes:
        corner_sigma: Of a detected corner along each image axis, by itself [px].
        common_sigma: Of all four corners of a tag alike [px].
        decimate: See `TagDetector`; None for what the tag's size in each camera's images allows.
        workers: Detections at a time.
        gate: Poses whose squared Mahalanobis distance is larger contradict each other; of three
            degrees of freedom 21.1 is passed by chance once in 10,000 times.
        misfit_gate: The same of a tag's corners, five degrees of freedom: 40 is passed once in
            seven million times; more than that is no level tag of the given size.
        edge: A tag with a corner this near to the image's edge may be cut off [px].
        slot: Images whose stamps differ by no more than this belong together [s].
        acceleration: White noise that drives the speed [m/s² per √Hz] …
        turn_acceleration: … and the turning rate [rad/s² per √Hz].
        lost_after: Without a measurement for this long the robot is lost [s].
        watched: So many latest comparisons say whether a camera moved …
        fewest: … but at least so many must contradict.

    Raises:
        InputError: A value makes no sense.
    """

    corner_sigma: float = CORNER_SIGMA
    common_sigma: float = COMMON_SIGMA
    decimate: float | None = None
    workers: int = 2
    gate: float = 21.1
    misfit_gate: float = 40.0
    edge: float = 3.0
    slot: float = 0.03
    acceleration: float = 0.3
    turn_acceleration: float = 1.0
    lost_after: float = 2.0
    watched: int = 20
    fewest: int = 8

    def __post_init__(self) -> None:
        positive = (
            "corner_sigma", "common_sigma", "gate", "misfit_gate", "acceleration",
            "turn_acceleration", "lost_after",
        )  # fmt: skip
        for name in positive:
            if not 0 < getattr(self, name) < float("inf"):
                raise InputError(f"{name} must be positive, not {getattr(self, name)}")
        if not (0 <= self.slot < self.lost_after and self.edge >= 0):
            raise InputError(f"images of one time differ by 0 s or more, not {self.slot} s")
        if self.workers < 1 or not 1 <= self.fewest <= self.watched:
            raise InputError(
                f"at least one worker and 1 to {self.watched} comparisons are needed, not "
                f"{self.workers} and {self.fewest}"
            )
