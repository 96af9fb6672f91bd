"""Motion models between frames: wheel odometry with scale, constant velocity, uncertainty."""

from circumspect.motion.motion_model import MotionModel, MotionSettings
from circumspect.motion.pose_with_covariance import PoseWithCovariance, RelativeMotion

__all__ = ["MotionModel", "MotionSettings", "PoseWithCovariance", "RelativeMotion"]
