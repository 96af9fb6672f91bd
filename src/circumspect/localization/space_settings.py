"""Settings of the intelligent space."""

from __future__ import annotations

from dataclasses import dataclass

from circumspect.errors import InputError
from circumspect.localization.tag_pose import COMMON_SIGMA, CORNER_SIGMA


@dataclass(frozen=True)
class SpaceSettings:
    """Settings of `IntelligentSpace`.

    Attributes:
        corner_sigma: Independent standard deviation of a detected corner along each image axis
            [px].
        common_sigma: Common standard deviation of the four corners of a tag [px].
        decimate: See `TagDetector`; None to derive it from the size of the tag in each image.
        workers: Number of parallel detections.
        max_squared_distance: Maximum squared Mahalanobis distance of poses that agree; with three
            degrees of freedom, 21.1 is exceeded by chance once in 10,000 times.
        max_squared_residual: Maximum squared residual of a tag's corners; with five degrees of
            freedom, 40 is exceeded by chance once in seven million times.
        edge: A tag with a corner this close to the edge of the image may be cut off [px].
        slot: Maximum difference of the stamps of simultaneous images [s].
        acceleration: Spectral density of the acceleration [m/s² per √Hz].
        turn_acceleration: Spectral density of the angular acceleration [rad/s² per √Hz].
        lost_after: Time without a measurement after which the robot is lost [s].
        comparison_window: Number of recent comparisons that decide whether a camera moved.
        min_contradictions: Minimum number of contradictions among them.

    Raises:
        InputError: A value is invalid.
    """

    corner_sigma: float = CORNER_SIGMA
    common_sigma: float = COMMON_SIGMA
    decimate: float | None = None
    workers: int = 2
    max_squared_distance: float = 21.1
    max_squared_residual: float = 40.0
    edge: float = 3.0
    slot: float = 0.03
    acceleration: float = 0.3
    turn_acceleration: float = 1.0
    lost_after: float = 2.0
    comparison_window: int = 20
    min_contradictions: int = 8

    def __post_init__(self) -> None:
        positive = (
            "corner_sigma", "common_sigma", "max_squared_distance", "max_squared_residual",
            "acceleration", "turn_acceleration", "lost_after",
        )  # fmt: skip
        for name in positive:
            if not 0 < getattr(self, name) < float("inf"):
                raise InputError(f"{name} must be positive, not {getattr(self, name)}")
        if not (0 <= self.slot < self.lost_after and self.edge >= 0):
            raise InputError(
                f"slot must be from 0 to lost_after, and edge not negative, not {self.slot} s"
            )
        if self.workers < 1 or not 1 <= self.min_contradictions <= self.comparison_window:
            raise InputError(
                f"at least one worker and 1 to {self.comparison_window} comparisons are needed, "
                f"not {self.workers} and {self.min_contradictions}"
            )
