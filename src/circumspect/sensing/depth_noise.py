"""Noise model of a structured-light depth camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing.millimetres import metres, millimetres

AXIAL = (0.0012, 0.0019, 0.4)
"""a, b [1/m] and c [m] of the frontal axial noise a + b (z - c)²."""
GRAZING_ANGLE_RAD = float(np.radians(60.0))


@dataclass(frozen=True)
class DepthNoise:
    """Noise of the Asus Xtion PRO.

    Axial and lateral noise follow Nguyen, Izadi and Lovell, "Modeling Kinect Sensor Noise for
    Improved 3D Reconstruction and Tracking" (3DIMPVT 2012), which measured the same sensor.

    Attributes:
        nearest, farthest: Range along z [m]; depths outside are missing.
        lateral_sigma: Standard deviation of the position that a pixel measures [px].
        baseline: Distance between projector and camera [m].
        disparity_step: Quantisation step of the disparity [px].
        steepest_incidence: Angle between ray and normal above which there is no measurement [rad].
        systematic_disparity: Standard deviation of the disparity error that is constant over frames
            [rad], caused by residual distortion and by quantisation of smooth surfaces. The default
            is 0.1 px at the sensor's focal length of 575 px.
        systematic_patch: Side of image patches with the same systematic error [rad].
        edge_jump: Relative depth difference of neighbours that makes an edge.
        edge_loss: Fraction of the pixels at depth edges that are missing.

    Raises:
        InputError: The range is invalid.
    """

    nearest: float = 0.8
    farthest: float = 3.5
    lateral_sigma: float = 0.8
    baseline: float = 0.075
    disparity_step: float = 0.125
    steepest_incidence: float = float(np.radians(80.0))
    systematic_disparity: float = 0.1 / 575
    systematic_patch: float = 32 / 575
    edge_jump: float = 0.03
    edge_loss: float = 0.5

    def __post_init__(self) -> None:
        if not 0 <= self.nearest < self.farthest:
            raise InputError(
                "the depth range must be the minimum and the maximum [m], not "
                f"{self.nearest:g} and {self.farthest:g}"
            )

    @property
    def depth_range(self) -> tuple[float, float]:
        """Minimum and maximum depth [m]."""
        return self.nearest, self.farthest

    def axial_sigma(
        self, depth: NDArray[np.floating], incidence: NDArray[np.floating] | float = 0.0
    ) -> NDArray[np.float32]:
        """Standard deviation of the depth before quantisation.

        Args:
            depth: z, any shape [m].
            incidence: θ, angle between ray and surface normal [rad], same shape or one value.

        Returns:
            σz = 0.0012 + 0.0019 (z − 0.4)² [m], and from 60° on 0.0001 θ² / (√z (π/2 − θ)²) more.
        """
        z = np.asarray(depth, dtype=np.float32)
        a, b, c = AXIAL
        sigma = a + b * (z - c) ** 2
        if isinstance(incidence, float) and incidence <= GRAZING_ANGLE_RAD:
            return sigma
        theta = np.minimum(np.asarray(incidence, dtype=np.float32), np.float32(1.55))
        grazing = 0.0001 / np.sqrt(z) * (theta / (np.pi / 2 - theta)) ** 2
        return (sigma + np.where(theta > GRAZING_ANGLE_RAD, grazing, 0)).astype(np.float32)

    def systematic_sigma(self, depth: NDArray[np.floating]) -> NDArray[np.float64]:
        """Standard deviation of the depth error common to the pixels of a patch [m]: δ z² / b.

        Herrera, Kannala and Heikkilä ("Joint depth and color camera calibration with distortion
        correction", PAMI 2012) found such errors of the Kinect's disparities.

        Args:
            depth: z, any shape [m].
        """
        z = np.asarray(depth, dtype=np.float64)
        return z**2 * self.systematic_disparity / self.baseline

    def quantisation_step(
        self, depth: NDArray[np.floating], camera: PinholeCamera
    ) -> NDArray[np.float32]:
        """Distance between neighbouring depths that the sensor can report [m]."""
        z = np.asarray(depth, dtype=np.float32)
        return (z**2 * self.disparity_step / (camera.fx * self.baseline)).astype(np.float32)

    def coefficients(self, camera: PinholeCamera) -> tuple[float, float, float, float]:
        """a, b, c of the frontal axial noise a + b (z - c)², and d of the step d z²."""
        return (*AXIAL, self.disparity_step / (camera.fx * self.baseline))

    def applied(
        self,
        depth: NDArray[np.floating],
        incidence: NDArray[np.floating],
        camera: PinholeCamera,
        rng: np.random.Generator,
    ) -> NDArray[np.float32]:
        """Simulate the measurement of a true depth image.

        Args:
            depth: (height, width) [m] true depth, NaN where nothing is hit.
            incidence: (height, width) [rad] angle between ray and surface normal.
            camera: The camera.
            rng: Source of the noise; the same state gives the same image.

        Returns:
            (height, width) float32 [m] in whole millimetres, as provided by the sensor's driver;
            NaN where it provides no depth.
        """
        looked_at = self._jittered_pixels(depth.shape, rng)
        z = depth.ravel()[looked_at].astype(np.float32)
        theta = incidence.ravel()[looked_at].astype(np.float32)
        noise = rng.standard_normal(depth.shape, dtype=np.float32)
        with np.errstate(invalid="ignore", divide="ignore"):
            measured = self._quantised(z + self.axial_sigma(z, theta) * noise, camera)
            lost = theta > self.steepest_incidence
            lost |= (measured < self.nearest) | (measured > self.farthest)
            lost |= self._at_edge(depth) & (rng.random(depth.shape, np.float32) < self.edge_loss)
        measured[lost] = np.nan
        return metres(millimetres(measured))

    def _jittered_pixels(
        self, shape: tuple[int, ...], rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """(height, width) flat index of the pixel that each pixel actually measures."""
        height, width = shape
        shift = rng.standard_normal((2, height, width), dtype=np.float32) * self.lateral_sigma
        shift = np.rint(shift).astype(np.intp)
        v = np.clip(np.arange(height)[:, None] + shift[0], 0, height - 1)
        u = np.clip(np.arange(width)[None, :] + shift[1], 0, width - 1)
        return v * width + u

    def _quantised(self, depth: NDArray[np.floating], camera: PinholeCamera) -> NDArray[np.float32]:
        steps = np.rint(camera.fx * self.baseline / self.disparity_step / depth)
        return (camera.fx * self.baseline / self.disparity_step / steps).astype(np.float32)

    def _at_edge(self, depth: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Pixels with a 4-neighbour across a jump in depth, or next to missing depth."""
        known = np.where(np.isfinite(depth), depth, np.float32(1e3))
        edge = np.zeros(depth.shape, bool)
        for axis in (0, 1):
            near, far = np.moveaxis(known, axis, 0)[:-1], np.moveaxis(known, axis, 0)[1:]
            jump = np.abs(far - near) > self.edge_jump * np.minimum(near, far)
            along = np.moveaxis(edge, axis, 0)
            along[:-1] |= jump
            along[1:] |= jump
        return edge
