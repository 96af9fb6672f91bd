"""The mobile robot: its interface, its kinematics, its odometry, and how it follows a path."""

from circumspect.robot.differential_drive import DifferentialDrive, arc
from circumspect.robot.mobile_robot import MobileRobot
from circumspect.robot.operated_robot import OperatedRobot, Operator, RunStopped
from circumspect.robot.path_follower import PathFollower
from circumspect.robot.velocity import Velocity
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
