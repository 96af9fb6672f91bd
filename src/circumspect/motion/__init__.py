"""How a camera moves between frames: wheel odometry with scale, constant velocity, uncertainty."""

from circumspect.motion.motion_model import MotionModel, MotionSettings
from circumspect.motion.pose_with_covariance import PoseWithCovariance
from circumspect.motion.relative_motion import RelativeMotion

__all__ = ["MotionModel", "MotionSettings", "PoseWithCovariance", "RelativeMotion"]
