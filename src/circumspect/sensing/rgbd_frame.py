"""RGB-D frames, and the base class of RGB-D cameras."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.geometry.composition import composed
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.geometry.given_shapes import require_transform
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.millimetres import metres
from circumspect.sensing.odometry import Odometry
from circumspect.sensing.pixel_rays import pixel_rays

MIN_DEPTH_M = 1e-4
"""Minimum valid depth [m]; smaller values are integers that were read as floats."""


class RgbdCamera(ABC):
    """Takes one frame at a time."""

    @property
    @abstractmethod
    def intrinsics(self) -> PinholeCamera:
        """Size, focal length and principal point of the depth images."""

    @property
    def depth_range(self) -> tuple[float, float]:
        """Minimum and maximum depth of the camera [m]; by default those of the Xtion PRO.

        Other cameras override this: views are planned so that the object is within range.
        """
        return DepthNoise().depth_range

    @abstractmethod
    def capture(self) -> RgbdFrame:
        """Take the next frame."""

    def frames(self, count: int) -> Iterator[RgbdFrame]:
        """Take `count` frames, lazily."""
        for _ in range(count):
            yield self.capture()


@dataclass(frozen=True, eq=False)
class RgbdFrame(ReadOnlyArrays):
    """Depth and optionally colour of one image; arrays are read-only.

    Attributes:
        depth: (height, width) float32 [m] along the optical z axis; NaN is invalid. Infinite
            and masked values and those below `MIN_DEPTH_M` become NaN.
        camera: Intrinsics of the camera.
        stamp: Time [s].
        T_map_camera: Estimated pose of the camera (optical frame), or None.
        colour: (height, width, 3) uint8 RGB, or None.
        odometry: Wheel odometry at that time, or None.
        T_base_camera: Mount of the camera on the robot, or None.

    Raises:
        InputError: Depth or colour do not have the camera's size; stamp, pose or mount are not
            finite; or a value has the wrong type.
    """

    depth: NDArray[np.float32]
    camera: PinholeCamera
    stamp: float
    T_map_camera: RigidTransform | None = None
    colour: NDArray[np.uint8] | None = None
    odometry: Odometry | None = None
    T_base_camera: RigidTransform | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.camera, PinholeCamera):
            raise InputError(
                f"camera must be a PinholeCamera, not {type(self.camera).__name__}; make one with "
                "circumspect.PinholeCamera(width, height, fx, fy, cx, cy)"
            )
        size = (self.camera.height, self.camera.width)
        depth = np.array(self.depth, dtype=np.float32)
        if depth.shape != size:
            raise InputError(f"depth has shape {depth.shape}, the camera makes {size}")
        if isinstance(self.depth, np.ma.MaskedArray):
            depth[np.ma.getmaskarray(self.depth)] = np.nan
        depth[~(np.isfinite(depth) & (depth >= MIN_DEPTH_M))] = np.nan
        depth.flags.writeable = False
        object.__setattr__(self, "depth", depth)
        if not np.isfinite(self.stamp):
            raise InputError(f"the frame's stamp is {self.stamp}; give seconds")
        if self.T_map_camera is not None:
            require_transform(self.T_map_camera, "T_map_camera")
            _finite(self.T_map_camera, "pose", self.stamp)
        if self.T_base_camera is not None:
            require_transform(self.T_base_camera, "T_base_camera")
            _finite(self.T_base_camera, "mount (T_base_camera)", self.stamp)
        if self.odometry is not None and not isinstance(self.odometry, Odometry):
            raise InputError(
                f"odometry must be an Odometry, not {type(self.odometry).__name__}; make one with "
                "circumspect.Odometry(stamp, T_odom_base)"
            )
        if self.colour is not None:
            colour = np.array(self.colour, dtype=np.uint8)
            if colour.shape != (*size, 3):
                raise InputError(f"colour has shape {colour.shape}, expected {(*size, 3)}")
            colour.flags.writeable = False
            object.__setattr__(self, "colour", colour)

    @classmethod
    def from_millimetres(
        cls,
        depth: ArrayLike,
        camera: PinholeCamera,
        stamp: float,
        T_map_camera: RigidTransform | None = None,
        colour: NDArray[np.uint8] | None = None,
    ) -> RgbdFrame:
        """Create a frame from depth in millimetres (16UC1, REP 118).

        Args:
            depth: (height, width) uint16 or float32 [mm]; 0, 65535, NaN and masked values are
                invalid.
            camera: Intrinsics of the camera.
            stamp: Time [s].
            T_map_camera: See the class.
            colour: See the class.

        Raises:
            InputError: See the class.
        """
        return cls(metres(np.ma.filled(depth, 0)), camera, stamp, T_map_camera, colour)

    @property
    def valid(self) -> NDArray[np.bool_]:
        """(height, width) pixels with a depth."""
        return np.isfinite(self.depth)

    @property
    def pose(self) -> RigidTransform:
        """`T_map_camera`.

        Raises:
            InputError: The frame has no pose.
        """
        if self.T_map_camera is None:
            raise InputError(f"the frame at {self.stamp:.3f} s has no pose; register it first")
        return self.T_map_camera

    @property
    def T_odom_camera(self) -> RigidTransform | None:
        """Pose of the camera by odometry only; None without odometry or mount."""
        if self.odometry is None or self.T_base_camera is None:
            return None
        return composed(self.odometry.T_odom_base.as_transform(), self.T_base_camera)

    def covered(self) -> RgbdFrame:
        """The frame as if the camera were covered: no depth, and black colour."""
        colour = None if self.colour is None else np.zeros_like(self.colour)
        return replace(self, depth=np.full_like(self.depth, np.nan), colour=colour)

    def at(self, T_map_camera: RigidTransform) -> RgbdFrame:
        """The frame with another pose.

        Raises:
            InputError: The pose is not finite, or not a RigidTransform.
        """
        T_map_camera = require_transform(T_map_camera, "T_map_camera")
        # The image was checked when the frame was created, and is read-only.
        frame = copy(self)
        object.__setattr__(frame, "T_map_camera", _finite(T_map_camera, "pose", self.stamp))
        return frame

    def points_map(self, mask: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
        """Points of the valid pixels in the map frame.

        Args:
            mask: (height, width) pixels to use; None for all.

        Returns:
            (n, 3) [m], row by row.

        Raises:
            InputError: The frame has no pose.
        """
        wanted = self.valid if mask is None else mask & self.valid
        matrix = self.pose.as_matrix()
        # Single precision until the camera's position is added, which may be large.
        chosen = np.flatnonzero(wanted)
        rays = pixel_rays(self.camera).reshape(-1, 3).take(chosen, axis=0)
        points = rays * self.depth.take(chosen)[:, None]
        return points @ matrix[:3, :3].T.astype(np.float32) + matrix[:3, 3]

    def sparse_points_map(self, step: int, mask: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Like `points_map`, for every `step`-th pixel of every `step`-th row in a mask.

        Args:
            step: [px].
            mask: (height, width).

        Returns:
            (n, 3) [m], row by row.

        Raises:
            InputError: The frame has no pose.
        """
        depth = self.depth[::step, ::step]
        chosen = mask[::step, ::step] & np.isfinite(depth)
        matrix = self.pose.as_matrix()
        points = pixel_rays(self.camera)[::step, ::step][chosen] * depth[chosen][:, None]
        return points @ matrix[:3, :3].T.astype(np.float32) + matrix[:3, 3]


def _finite(T: RigidTransform, name: str, stamp: float) -> RigidTransform:
    if not np.isfinite(T.as_matrix()).all():
        raise InputError(f"the {name} of the frame at {stamp:.3f} s is not finite")
    return T
