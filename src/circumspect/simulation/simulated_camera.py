"""A simulated RGB-D camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise, RgbdCamera, RgbdFrame
from circumspect.simulation.ray_caster import RayCaster, View
from circumspect.simulation.scene import Scene
from circumspect.simulation.station import Station

BACKGROUND = (0.90, 0.92, 0.95)


@dataclass(frozen=True, eq=False)
class DepthDistortion:
    """Residual distortion of a structured-light camera after calibration.

    A point at inverse depth 1/z is measured at 1/z + e/b, with e the error of its pixel and b the
    baseline. The pattern moves with the camera, so that a flat wall has the same bumps from all
    viewpoints.

    Attributes:
        errors: (height, width) float32 [rad] errors of the disparity.
        baseline: Baseline of the camera [m].
    """

    errors: NDArray[np.float32]
    baseline: float

    @classmethod
    def drawn(
        cls, noise: DepthNoise, camera: PinholeCamera, rng: np.random.Generator | int
    ) -> DepthDistortion:
        """Draw a random pattern.

        Independent errors at the nodes of a grid, `systematic_patch` apart, are interpolated
        linearly.

        Args:
            noise: Depth noise with the parameters of the pattern.
            camera: The camera.
            rng: Source of the pattern; the same seed gives the same pattern.
        """
        patch = noise.systematic_patch * camera.fx
        rows, columns = np.mgrid[: camera.height, : camera.width] / patch
        nodes = int(np.ceil(camera.height / patch)) + 2, int(np.ceil(camera.width / patch)) + 2
        drawn = np.random.default_rng(rng).normal(size=nodes)
        errors = ndimage.map_coordinates(drawn, [rows, columns], order=1)
        # Interpolation reduces the errors between the nodes.
        errors *= noise.systematic_disparity / errors.std()
        return cls(errors.astype(np.float32), noise.baseline)

    def require_size(self, camera: PinholeCamera) -> None:
        """Check that the pattern fits the images of a camera.

        Raises:
            InputError: The camera has another image size.
        """
        height, width = self.errors.shape
        if (height, width) != (camera.height, camera.width):
            raise InputError(
                f"the distortion has {width} x {height} pixels, the camera "
                f"{camera.width} x {camera.height}"
            )

    def applied(self, depth: NDArray[np.floating]) -> NDArray[np.float32]:
        """Distort a depth image, (height, width) [m]; NaN stays NaN."""
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / depth + self.errors / self.baseline
            return np.where(inverse > 0, 1 / inverse, np.nan).astype(np.float32)


class SimulatedCamera(RgbdCamera):
    """A camera in a simulated scene; see `RgbdCamera`."""

    def __init__(
        self,
        scene: Scene,
        station: Callable[[], Station],
        intrinsics: PinholeCamera | None = None,
        noise: DepthNoise | None = None,
        rng: np.random.Generator | int = 0,
        colour: bool = False,
        with_pose: bool = True,
        distortion: DepthDistortion | None = None,
    ) -> None:
        """Create a camera.

        Args:
            scene: The scene.
            station: Returns the current station of the camera; called at each capture.
            intrinsics: Intrinsics; None means the Xtion PRO.
            noise: The depth noise; None means exact depth.
            rng: Source of the noise; the same seed gives the same frames.
            colour: Whether to render shaded colour images.
            with_pose: Whether frames contain their true poses.
            distortion: Errors that are the same in every image; None means none.

        Raises:
            InputError: The distortion has another image size.
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
        self._with_pose = with_pose

    @property
    def intrinsics(self) -> PinholeCamera:
        """See `RgbdCamera.intrinsics`."""
        return self._intrinsics

    @property
    def depth_range(self) -> tuple[float, float]:
        """See `RgbdCamera.depth_range`; without noise that of the Xtion PRO."""
        return (self._noise or DepthNoise()).depth_range

    def capture(self) -> RgbdFrame:
        """See `RgbdCamera.capture`."""
        return self.photograph(self._station())

    def photograph(self, station: Station) -> RgbdFrame:
        """The frame at a given station."""
        view = self.truth(station)
        depth = view.depth
        if self._distortion is not None:
            depth = self._distortion.applied(depth)
        if self._noise is not None:
            depth = self._noise.applied(depth, view.incidence, self._intrinsics, self._rng)
        colour = shaded(view, self._caster.scene) if self._colour else None
        pose = station.T_map_camera if self._with_pose else None
        return RgbdFrame(depth, self._intrinsics, station.stamp, pose, colour)

    def truth(self, station: Station) -> View:
        """The true view at a station; for tests and measurements, not for the robot."""
        return self._caster.view(self._intrinsics, station.T_map_camera)


def shaded(view: View, scene: Scene) -> NDArray[np.uint8]:
    """(height, width, 3) RGB: each surface's colour, darker at oblique incidence."""
    palette = np.array([surface.colour for surface in scene.surfaces] + [BACKGROUND], np.float32)
    light = 0.35 + 0.65 * np.cos(view.incidence)
    light[view.surface < 0] = 1.0
    return np.rint(255 * palette[view.surface] * light[..., None]).astype(np.uint8)
