"""The path of the camera by odometry alone, during a run."""

from __future__ import annotations

from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.recognition import RecognitionStep
from circumspect.sensing import RgbdFrame


class OdometryPath:
    """Starts at the pose of the first frame that has both a pose and odometry.

    Attributes:
        frames: Numbers of the frames with odometry.
        places_xyz: Position of the camera at each [m], map frame.
    """

    def __init__(self) -> None:
        """Start empty."""
        self.frames: list[int] = []
        self.places_xyz: list[tuple[float, float, float]] = []
        self._T_map_odom: RigidTransform | None = None

    def add(self, step: RecognitionStep, frame: RgbdFrame | None) -> None:
        """Add a frame, if it has odometry and mount."""
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

    def truncate(self, kept: int) -> None:
        """Keep the newest positions only.

        Args:
            kept: Number of positions.
        """
        self.frames, self.places_xyz = self.frames[-kept:], self.places_xyz[-kept:]
