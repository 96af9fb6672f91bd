"""Where a camera was by odometry alone, while a run goes on."""

from __future__ import annotations

from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.recognition.recognition_step import RecognitionStep
from circumspect.sensing import RgbdFrame


class WheelPath:
    """Begins at the first frame that has both a pose and odometry, where that pose is.

    Attributes:
        frames: Numbers of the frames with odometry.
        places_xyz: The camera's place at each [m], map frame.
    """

    def __init__(self) -> None:
        """Begin empty."""
        self.frames: list[int] = []
        self.places_xyz: list[tuple[float, float, float]] = []
        self._T_map_odom: RigidTransform | None = None

    def follow(self, step: RecognitionStep, frame: RgbdFrame | None) -> None:
        """Take one more frame; one without odometry or mount adds nothing."""
        if frame is None or (T_odom_camera := frame.T_odom_camera) is None:
            return
        T_map_odom = self._T_map_odom
        if T_map_odom is None:
            if step.pose is None:
                return
            T_map_odom = self._T_map_odom = composed(step.pose.T_map_camera, T_odom_camera.inv())
        self.frames.append(step.index)
        x, y, z = composed(T_map_odom, T_odom_camera).translation.tolist()
        self.places_xyz.append((x, y, z))

    def forget(self, kept: int) -> None:
        """Keep the newest places only; where the path began stays known.

        Args:
            kept: So many.
        """
        self.frames, self.places_xyz = self.frames[-kept:], self.places_xyz[-kept:]
