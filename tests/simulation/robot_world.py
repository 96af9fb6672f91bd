"""Small worlds for robots: one tiny camera, few triangles."""

from __future__ import annotations

import numpy as np

from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.robot import MobileRobot, Velocity
from circumspect.simulation import (
    CameraMount,
    RobotSettings,
    Scene,
    SimulatedRobot,
    Surface,
    block,
    floor,
)

CAMERA = PinholeCamera(64, 48, 57.0, 57.0, 31.5, 23.5)
EMPTY = Scene((Surface("floor", floor(20.0)),))
BOX = Scene.with_object(block((-0.3, -0.3, 0.0), (0.3, 0.3, 0.7)))
ON_CIRCLE = PlanarPose(1.5, 0.0, np.pi / 2)
ROUND = Velocity(0.3, 0.3 / 1.5)


def robot(
    scene: Scene = BOX, start: PlanarPose = ON_CIRCLE, seed: int = 0, **settings: float
) -> SimulatedRobot:
    return SimulatedRobot(scene, start, CameraMount(), RobotSettings(**settings), CAMERA, seed=seed)


def true_pose(driver: SimulatedRobot) -> PlanarPose:
    return PlanarPose.from_transform(driver.truth().T_map_base)


def odometry_pose(driver: MobileRobot) -> PlanarPose:
    odometry = driver.odometry()
    assert odometry is not None
    return odometry.T_odom_base
