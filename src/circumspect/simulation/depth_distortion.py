"""Disparity errors of a camera that stay the same in every image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise


@dataclass(frozen=True, eq=False)
class DepthDistortion:
    """What calibration left of a structured-light camera's distortion.

    A point at inverse depth 1/z is measured at 1/z + e/b, with e the error of its pixel and b the
    baseline. The pattern moves with the camera, so that a flat wall has the same bumps from
    everywhere.

    Attributes:
        errors: (height, width) float32 [rad] errors of the disparity.
        baseline: Of the camera [m].
    """

    errors: NDArray[np.float32]
    baseline: float

    @classmethod
    def drawn(
        cls, noise: DepthNoise, camera: PinholeCamera, rng: np.random.Generator | int
    ) -> DepthDistortion:
        """A random pattern as a sensor's description has it.

        Independent errors at the nodes of a grid, `systematic_patch` apart, are interpolated
        linearly.

        Args:
            noise: The description.
            camera: The camera.
            rng: Source of the pattern; the same seed gives the same pattern.
        """
        patch = noise.systematic_patch * camera.fx
        rows, columns = np.mgrid[: camera.height, : camera.width] / patch
        nodes = int(np.ceil(camera.height / patch)) + 2, int(np.ceil(camera.width / patch)) + 2
        drawn = np.random.default_rng(rng).normal(size=nodes)
        errors = ndimage.map_coordinates(drawn, [rows, columns], order=1)
        # Interpolation makes it smaller between the nodes.
        errors *= noise.systematic_disparity / errors.std()
        return cls(errors.astype(np.float32), noise.baseline)

    def require_size(self, camera: PinholeCamera) -> None:
        """Check that this is the distortion of a camera.

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
        """The distorted image of a true one, (height, width) [m]; NaN stays NaN."""
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / depth + self.errors / self.baseline
            return np.where(inverse > 0, 1 / inverse, np.nan).astype(np.float32)
