"""Settings of `circumspect locate simulate`, importable without heavy packages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from circumspect.errors import InputError

TICK = 0.02
"""Minimum time between two images of a camera [s]."""


@dataclass(frozen=True)
class SpaceSetup:
    """Settings of a simulation of ceiling cameras.

    Attributes:
        cameras: Number of cameras.
        ceiling: Height of the cameras above the floor [m].
        speed: The robot's speed [m/s].
        seconds: Maximum driving time [s]; the drive ends once round the object.
        rate: Images per second of each camera.
        slip: Fraction of the wheels' travel that does not become motion.
        calibrate: all: calibrate intrinsics and poses of the cameras from images; extrinsics: the
            poses alone; none: use the true calibration.
        moved: Name of a camera that is displaced by 40 mm after calibration, such as ceiling_0.
        seed: Random seed.
        size: Size of the images [px].

    Raises:
        InputError: A value is invalid.
    """

    cameras: int = 4
    ceiling: float = 3.0
    speed: float = 0.2
    seconds: float = 60.0
    rate: float = 10.0
    slip: float = 0.05
    calibrate: Literal["all", "extrinsics", "none"] = "extrinsics"
    moved: str | None = None
    seed: int = 0
    size: tuple[int, int] = (1280, 960)

    def __post_init__(self) -> None:
        if not (0 < self.speed <= 1 and 0 < self.seconds <= 3600):
            raise InputError(f"no robot drives {self.speed} m/s for {self.seconds} s; try 0.2, 60")
        if not 0.1 <= self.rate <= 1 / TICK:
            raise InputError(f"--rate {self.rate}: from 0.1 to {1 / TICK:g} images a second")
        if not all(64 <= side <= 8192 for side in self.size):
            raise InputError(f"--size {self.size[0]} {self.size[1]}: from 64 to 8192 pixels")
        if not 1 <= self.cameras <= 64:
            raise InputError(f"--cameras {self.cameras}: give 1 to 64")
