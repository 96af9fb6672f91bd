"""Mobile robots: base class, kinematics, odometry and path following."""

from circumspect.robot.differential_drive import DifferentialDrive, arc
from circumspect.robot.mobile_robot import MobileRobot, Velocity
from circumspect.robot.operated_robot import OperatedRobot, Operator, RunStopped
from circumspect.robot.path_follower import PathFollower
from circumspect.robot.wheel_odometry import WheelOdometry
from circumspect.robot.wrapped_robot import WrappedRobot

__all__ = [
    "DifferentialDrive",
    "MobileRobot",
    "OperatedRobot",
    "Operator",
    "PathFollower",
    "RunStopped",
    "Velocity",
    "WheelOdometry",
    "WrappedRobot",
    "arc",
]
