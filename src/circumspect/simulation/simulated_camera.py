"""A virtual RGB-D camera."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise, RgbdCamera, RgbdFrame
from circumspect.simulation.depth_distortion import DepthDistortion
from circumspect.simulation.ray_caster import RayCaster, View
from circumspect.simulation.scene import Scene
from circumspect.simulation.station import Station

BACKGROUND = (0.90, 0.92, 0.95)


class SimulatedCamera(RgbdCamera):
    """Sees a scene from wherever its carrier is; see `RgbdCamera`."""

    def __init__(
        self,
        scene: Scene,
        station: Callable[[], Station],
        intrinsics: PinholeCamera | None = None,
        noise: DepthNoise | None = None,
        rng: np.random.Generator | int = 0,
        colour: bool = False,
        tell_pose: bool = True,
        distortion: DepthDistortion | None = None,
    ) -> None:
        """Set up.

        Args:
            scene: What can be seen.
            station: Called at each capture: where the camera is now.
            intrinsics: Size and focal length; None means the Xtion PRO.
            noise: The depth noise; None means exact depth.
            rng: Source of the noise; the same seed gives the same frames.
            colour: Also make shaded colour images.
            tell_pose: Frames carry the pose that they were taken from.
            distortion: Errors that stay the same in every image; None means none.

        Raises:
            InputError: The distortion is that of another image size.
            MissingExtraError: Embree is not installed.
        """
        self._intrinsics = intrinsics or PinholeCamera.xtion()
        if distortion is not None:
            distortion.require_size(self._intrinsics)
        self._distortion = distortion
        self._caster = RayCaster(scene)
        self._station = station
        self._noise = noise
        self._rng = np.random.default_rng(rng)
        self._colour = colour
        self._tell_pose = tell_pose

    @property
    def intrinsics(self) -> PinholeCamera:
        """See `RgbdCamera.intrinsics`."""
        return self._intrinsics

    @property
    def depth_range(self) -> tuple[float, float]:
        """See `RgbdCamera.depth_range`; of exact depth that of the Xtion PRO, too."""
        return (self._noise or DepthNoise()).depth_range

    def capture(self) -> RgbdFrame:
        """See `RgbdCamera.capture`."""
        return self.photograph(self._station())

    def photograph(self, station: Station) -> RgbdFrame:
        """The frame from a given place."""
        view = self.truth(station)
        depth = view.depth
        if self._distortion is not None:
            depth = self._distortion.applied(depth)
        if self._noise is not None:
            depth = self._noise.applied(depth, view.incidence, self._intrinsics, self._rng)
        colour = shaded(view, self._caster.scene) if self._colour else None
        pose = station.T_map_camera if self._tell_pose else None
        return RgbdFrame(depth, self._intrinsics, station.stamp, pose, colour)

    def truth(self, station: Station) -> View:
        """What is really there; for tests and measurements, never for the robot."""
        return self._caster.view(self._intrinsics, station.T_map_camera)


def shaded(view: View, scene: Scene) -> NDArray[np.uint8]:
    """(height, width, 3) RGB: each surface's colour, darker where it turns from the camera."""
    palette = np.array([surface.colour for surface in scene.surfaces] + [BACKGROUND], np.float32)
    light = 0.35 + 0.65 * np.cos(view.incidence)
    light[view.surface < 0] = 1.0
    return np.rint(255 * palette[view.surface] * light[..., None]).astype(np.uint8)
