"""The interface of everything that makes RGB-D frames: real, replayed or simulated."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator

from circumspect.geometry import PinholeCamera
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.rgbd_frame import RgbdFrame


class RgbdCamera(ABC):
    """Makes one frame at a time."""

    @property
    @abstractmethod
    def intrinsics(self) -> PinholeCamera:
        """Size, focal length and principal point of the depth images."""

    @property
    def depth_range(self) -> tuple[float, float]:
        """The nearest and the farthest depth that it measures [m]; those of the Xtion PRO.

        Another camera's driver tells its own: views are planned so that the object lies within.
        """
        return DepthNoise().depth_range

    @abstractmethod
    def capture(self) -> RgbdFrame:
        """Take the next frame."""

    def frames(self, count: int) -> Iterator[RgbdFrame]:
        """Take `count` frames, each when it is asked for."""
        for _ in range(count):
            yield self.capture()
