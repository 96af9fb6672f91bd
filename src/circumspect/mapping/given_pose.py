"""The pose that was given for the first frame, until there is a map."""

from __future__ import annotations

from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import between, composed
from circumspect.sensing import RgbdFrame


class GivenPose:
    """Goes on with the wheels over frames that begin no map."""

    def __init__(self, T_map_camera: RigidTransform | None) -> None:
        """Begin.

        Args:
            T_map_camera: Of the first frame; None where nothing was given.
        """
        self._T_map_camera = T_map_camera
        self._T_odom_camera: RigidTransform | None = None

    def at(self, frame: RgbdFrame) -> RigidTransform | None:
        """`T_map_camera` of the next frame; None where nothing was given."""
        before, now = self._T_odom_camera, frame.T_odom_camera
        if self._T_map_camera is not None and before is not None and now is not None:
            self._T_map_camera = composed(self._T_map_camera, between(before, now))
        if now is not None:
            self._T_odom_camera = now
        return self._T_map_camera
