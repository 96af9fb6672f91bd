"""All ceiling cameras of a room, and the robot as they see it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.localization import CeilingImage, FixedCamera, TagMount
from circumspect.simulation.ceiling_camera import CeilingCamera, CeilingOptics, Shown
from circumspect.simulation.plate import Plate
from circumspect.simulation.ray_caster import RayCaster
from circumspect.simulation.scene import Scene
from circumspect.simulation.simulated_robot import Truth

PLATE_RADIUS, PLATE_GREY = 0.24, 0.25
"""The robot's top is a dark disc [m] with the tag on it."""
MOMENTS = 4
"""So many poses make the image of a robot that moves."""


class CeilingRig:
    """Takes an image with every camera at the same time.

    Where the robot is it hears from the simulation; the robot hears nothing of it. Of the robot
    the cameras see its top plate only, not the mast.
    """

    def __init__(
        self,
        cameras: Sequence[FixedCamera],
        scene: Scene,
        mount: TagMount | None = None,
        optics: CeilingOptics | None = None,
        seed: int = 0,
    ) -> None:
        """Hang the cameras.

        Args:
            cameras: As they hang in truth.
            scene: What stands still.
            mount: The robot's tag.
            optics: Of all cameras.
            seed: Of all chance.

        Raises:
            MissingExtraError: Embree or OpenCV is not installed.
        """
        self.mount = mount or TagMount()
        self.optics = optics or CeilingOptics()
        self._tag = Plate.tag(self.mount.tag_id, self.mount.size)
        self._top = Plate.disc(PLATE_RADIUS, PLATE_GREY)
        caster = RayCaster(scene)
        rngs = np.random.default_rng(seed).spawn(len(cameras))
        self.cameras = tuple(
            CeilingCamera(camera, caster, self.optics, rng)
            for camera, rng in zip(cameras, rngs, strict=True)
        )
        self._last: Truth | None = None

    def images(self, truth: Truth, others: Sequence[Shown] = ()) -> tuple[CeilingImage, ...]:
        """One image a camera.

        Args:
            truth: Where the robot is; since the last one it moved evenly.
            others: Other plates in the room.
        """
        shown = (*others, *self.robot(self._moments(truth)))
        self._last = truth
        return tuple(camera.photograph(truth.stamp, shown) for camera in self.cameras)

    def robot(self, T_map_base: Sequence[RigidTransform]) -> tuple[Shown, ...]:
        """The plates of a robot.

        Args:
            T_map_base: Its poses during the exposure, at least one.
        """
        T_base_top = _raised(self.mount.height - 0.002)
        T_base_tag = _raised(self.mount.height) * self.mount.T_base_tag.as_transform()
        top, tag = (tuple(T * part for T in T_map_base) for part in (T_base_top, T_base_tag))
        middle = len(T_map_base) // 2
        return Shown(self._top, top[middle], top), Shown(self._tag, tag[middle], tag)

    def _moments(self, truth: Truth) -> tuple[RigidTransform, ...]:
        """Poses of the base while the shutter is open."""
        last, exposure = self._last, self.optics.exposure
        if last is None or not last.stamp < truth.stamp or exposure == 0:
            return (truth.T_map_base,)
        motion = (last.T_map_base.inv() * truth.T_map_base).as_exp_coords()
        rate = motion / (truth.stamp - last.stamp)
        seconds = exposure * ((np.arange(MOMENTS) + 0.5) / MOMENTS - 0.5)
        return tuple(truth.T_map_base * RigidTransform.from_exp_coords(rate * s) for s in seconds)


def _raised(height: float) -> RigidTransform:
    return RigidTransform.from_components([0.0, 0.0, height], Rotation.identity())
