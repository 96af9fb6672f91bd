"""Measures of answers: accuracy over yaw, confusion, calibration, and their figures."""

from circumspect.evaluation.calibration import Reliability, reliability
from circumspect.evaluation.predictor import Predictor, TrainedPredictor, load_predictor
from circumspect.evaluation.trajectory_error import (
    Alignment,
    TrajectoryError,
    absolute_trajectory_error,
    relative_pose_error,
)
from circumspect.evaluation.yaw_sweep import YawSweep, spread_yaws, sweep_yaw

__all__ = [
    "Alignment",
    "Predictor",
    "Reliability",
    "TrainedPredictor",
    "TrajectoryError",
    "YawSweep",
    "absolute_trajectory_error",
    "load_predictor",
    "relative_pose_error",
    "reliability",
    "spread_yaws",
    "sweep_yaw",
]
