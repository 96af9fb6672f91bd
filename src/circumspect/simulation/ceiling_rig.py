"""The ceiling cameras of a room and the plates of the robot."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.localization import (
    CeilingImage,
    FixedCamera,
    IntelligentSpace,
    SpaceFix,
    SpaceTrack,
    TagMount,
)
from circumspect.simulation.ceiling_camera import CeilingCamera, CeilingOptics, PlacedPlate
from circumspect.simulation.plate import Plate
from circumspect.simulation.ray_caster import RayCaster
from circumspect.simulation.scene import Scene
from circumspect.simulation.simulated_robot import TrueState

PLATE_RADIUS, PLATE_GREY = 0.24, 0.25
"""Radius [m] and grey of the dark disc on the robot's top, which carries the tag."""
EXPOSURE_SAMPLES = 4
"""Number of poses during the exposure of a moving robot."""


class CeilingTracker:
    """Tracks the robot in images of the ceiling cameras; an observer of `GroundTruthRecorder`.

    Attributes:
        listeners: Called with every image.
    """

    def __init__(self, rig: CeilingRig, space: IntelligentSpace) -> None:
        """Start without images.

        Args:
            rig: The true cameras.
            space: The calibrated cameras.
        """
        self.rig, self.space = rig, space
        self.listeners: tuple[Callable[[CeilingImage], None], ...] = ()
        self._fixes: list[SpaceFix] = []

    def __call__(self, truth: TrueState) -> None:
        """Take images of the robot and localise it."""
        images = self.rig.images(truth)
        for listener in self.listeners:
            for image in images:
                listener(image)
        self._fixes.append(self.space.locate(images))

    @property
    def track(self) -> SpaceTrack:
        """The track so far."""
        return SpaceTrack.of(self._fixes, self.space.reports)


class CeilingRig:
    """Takes an image with every camera at the same time.

    The images show the true state, which the robot does not know. Only the robot's top plate is
    visible, not its mast.
    """

    def __init__(
        self,
        cameras: Sequence[FixedCamera],
        scene: Scene,
        mount: TagMount | None = None,
        optics: CeilingOptics | None = None,
        seed: int = 0,
    ) -> None:
        """Create the cameras.

        Args:
            cameras: The true cameras.
            scene: Static scene.
            mount: The robot's tag.
            optics: Optics of all cameras.
            seed: Seed of all random numbers.

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
        self._last: TrueState | None = None

    def images(
        self, truth: TrueState, others: Sequence[PlacedPlate] = ()
    ) -> tuple[CeilingImage, ...]:
        """Take one image per camera.

        Args:
            truth: True state of the robot; uniform motion since the previous one is assumed.
            others: Other plates in the room.
        """
        plates = (*others, *self.robot(self._exposure_poses(truth)))
        self._last = truth
        return tuple(camera.photograph(truth.stamp, plates) for camera in self.cameras)

    def robot(self, T_map_base: Sequence[RigidTransform]) -> tuple[PlacedPlate, ...]:
        """The plates of a robot.

        Args:
            T_map_base: Its poses during the exposure, at least one.
        """
        T_base_top = _at_height(self.mount.height - 0.002)
        T_base_tag = _at_height(self.mount.height) * self.mount.T_base_tag.as_transform()
        top, tag = (tuple(T * part for T in T_map_base) for part in (T_base_top, T_base_tag))
        middle = len(T_map_base) // 2
        return PlacedPlate(self._top, top[middle], top), PlacedPlate(self._tag, tag[middle], tag)

    def _exposure_poses(self, truth: TrueState) -> tuple[RigidTransform, ...]:
        """Poses of the base during the exposure."""
        last, exposure = self._last, self.optics.exposure
        if last is None or not last.stamp < truth.stamp or exposure == 0:
            return (truth.T_map_base,)
        motion = (last.T_map_base.inv() * truth.T_map_base).as_exp_coords()
        rate = motion / (truth.stamp - last.stamp)
        seconds = exposure * ((np.arange(EXPOSURE_SAMPLES) + 0.5) / EXPOSURE_SAMPLES - 0.5)
        return tuple(truth.T_map_base * RigidTransform.from_exp_coords(rate * s) for s in seconds)


def _at_height(height: float) -> RigidTransform:
    return RigidTransform.from_components([0.0, 0.0, height], Rotation.identity())
