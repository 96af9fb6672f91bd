"""Where the camera stands on the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.robot import DifferentialDrive
from circumspect.sensing.viewing import looking
from circumspect.simulation.orbit import MAST_HEIGHT, Orbit, require_mast


@dataclass(frozen=True)
class CameraMount:
    """On a mast over the left wheel, looking left and down.

    Attributes:
        height: Of the camera above the floor [m].
        tilt: How far it looks down [rad].
        left: How far left of `base_link` it stands [m].

    Raises:
        InputError: No mast is so low or high, or the camera would look straight up or down or
            stand beside the robot.
    """

    height: float = MAST_HEIGHT
    tilt: float = float(np.radians(30.0))
    left: float = DifferentialDrive().track / 2

    def __post_init__(self) -> None:
        require_mast(self.height)
        if not abs(self.tilt) < np.pi / 2:
            tilt = np.degrees(self.tilt)
            raise InputError(f"a camera on a mast is tilted by less than 90°, not by {tilt:g}°")
        if not abs(self.left) < 1:
            raise InputError(f"a mast stands on the robot, not {self.left:g} m beside its middle")

    @classmethod
    def for_orbit(cls, orbit: Orbit) -> CameraMount:
        """The mount whose camera, on an orbit, looks at the orbit's target."""
        drop = orbit.height - orbit.target_height
        return cls(orbit.height, float(np.arctan2(drop, orbit.radius)))

    @property
    def T_base_camera(self) -> RigidTransform:
        """The camera's pose on the robot, optical frame: x to the robot's front."""
        return looking([0.0, self.left, self.height], np.pi / 2, self.tilt)
