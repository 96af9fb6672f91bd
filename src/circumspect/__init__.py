"""circumspect: classify an object from any viewpoint.

Names are imported on first use, so that `import circumspect` is fast.
"""

from __future__ import annotations

TYPE_CHECKING = False  # Without an import: a command imports this before Ctrl-C ends it silently.
if TYPE_CHECKING:
    from typing import Any

    from circumspect.classification import CellEvidence as CellEvidence
    from circumspect.classification import Classifier as Classifier
    from circumspect.classification import GridSpec as GridSpec
    from circumspect.classification import Prediction as Prediction
    from circumspect.classification import cell_evidence as cell_evidence
    from circumspect.classification import nearest_examples as nearest_examples
    from circumspect.datasets import ObjectSet as ObjectSet
    from circumspect.datasets import furniture_set as furniture_set
    from circumspect.errors import CircumspectError as CircumspectError
    from circumspect.errors import GeometryError as GeometryError
    from circumspect.errors import InputError as InputError
    from circumspect.errors import MissingExtraError as MissingExtraError
    from circumspect.errors import OutputError as OutputError
    from circumspect.errors import WeightsError as WeightsError
    from circumspect.evaluation import Alignment as Alignment
    from circumspect.evaluation import YawSweep as YawSweep
    from circumspect.evaluation import absolute_trajectory_error as absolute_trajectory_error
    from circumspect.evaluation import spread_yaws as spread_yaws
    from circumspect.evaluation import sweep_yaw as sweep_yaw
    from circumspect.exploration import ObjectScan as ObjectScan
    from circumspect.exploration import ScanSettings as ScanSettings
    from circumspect.furniture import make_furniture as make_furniture
    from circumspect.geometry import PinholeCamera as PinholeCamera
    from circumspect.geometry import PlanarPose as PlanarPose
    from circumspect.geometry import PointCloud as PointCloud
    from circumspect.geometry import Trajectory as Trajectory
    from circumspect.geometry import TriangleMesh as TriangleMesh
    from circumspect.geometry import as_cloud as as_cloud
    from circumspect.geometry import cut_floor as cut_floor
    from circumspect.geometry import read_cloud as read_cloud
    from circumspect.geometry import read_mesh as read_mesh
    from circumspect.geometry import without_stray_points as without_stray_points
    from circumspect.geometry import write_ply as write_ply
    from circumspect.grid import CylindricalGrid as CylindricalGrid
    from circumspect.grid import OccupancyGrid as OccupancyGrid
    from circumspect.grid import RectangularGrid as RectangularGrid
    from circumspect.grid import angular_spectrum as angular_spectrum
    from circumspect.planning import CirclePlanner as CirclePlanner
    from circumspect.planning import SurfaceNormalPlanner as SurfaceNormalPlanner
    from circumspect.recognition import RecognitionPipeline as RecognitionPipeline
    from circumspect.recognition import RecognitionResult as RecognitionResult
    from circumspect.reconstruction import ObjectModel as ObjectModel
    from circumspect.robot import MobileRobot as MobileRobot
    from circumspect.robot import Velocity as Velocity
    from circumspect.runs import camera_path as camera_path
    from circumspect.sensing import DepthNoise as DepthNoise
    from circumspect.sensing import GroundSegmentation as GroundSegmentation
    from circumspect.sensing import Odometry as Odometry
    from circumspect.sensing import RgbdFrame as RgbdFrame
    from circumspect.simulation import GroundTruthRecorder as GroundTruthRecorder
    from circumspect.simulation import RobotSettings as RobotSettings
    from circumspect.simulation import SimulatedRobot as SimulatedRobot
    from circumspect.simulation import room as room
    from circumspect.tracking import KnownPoses as KnownPoses
    from circumspect.tracking import Tracker as Tracker
    from circumspect.tracking import TrackingSettings as TrackingSettings

__version__ = "0.1.0"

_HOMES = {
    "classification": (
        "CellEvidence",
        "Classifier",
        "GridSpec",
        "Prediction",
        "cell_evidence",
        "nearest_examples",
    ),
    "datasets": (
        "ObjectSet",
        "furniture_set",
    ),
    "errors": (
        "CircumspectError",
        "GeometryError",
        "InputError",
        "MissingExtraError",
        "OutputError",
        "WeightsError",
    ),
    "evaluation": (
        "Alignment",
        "YawSweep",
        "absolute_trajectory_error",
        "spread_yaws",
        "sweep_yaw",
    ),
    "exploration": (
        "ObjectScan",
        "ScanSettings",
    ),
    "furniture": ("make_furniture",),
    "geometry": (
        "PinholeCamera",
        "PlanarPose",
        "PointCloud",
        "Trajectory",
        "TriangleMesh",
        "as_cloud",
        "cut_floor",
        "read_cloud",
        "read_mesh",
        "without_stray_points",
        "write_ply",
    ),
    "grid": (
        "CylindricalGrid",
        "OccupancyGrid",
        "RectangularGrid",
        "angular_spectrum",
    ),
    "planning": (
        "CirclePlanner",
        "SurfaceNormalPlanner",
    ),
    "recognition": (
        "RecognitionPipeline",
        "RecognitionResult",
    ),
    "reconstruction": ("ObjectModel",),
    "robot": (
        "MobileRobot",
        "Velocity",
    ),
    "runs": ("camera_path",),
    "sensing": (
        "DepthNoise",
        "GroundSegmentation",
        "Odometry",
        "RgbdFrame",
    ),
    "simulation": (
        "RobotSettings",
        "SimulatedRobot",
        "GroundTruthRecorder",
        "room",
    ),
    "tracking": (
        "KnownPoses",
        "Tracker",
        "TrackingSettings",
    ),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Alignment",
    "CellEvidence",
    "CirclePlanner",
    "CircumspectError",
    "Classifier",
    "CylindricalGrid",
    "DepthNoise",
    "GeometryError",
    "GridSpec",
    "GroundSegmentation",
    "GroundTruthRecorder",
    "InputError",
    "KnownPoses",
    "MissingExtraError",
    "MobileRobot",
    "ObjectModel",
    "ObjectScan",
    "ObjectSet",
    "OccupancyGrid",
    "Odometry",
    "OutputError",
    "PinholeCamera",
    "PlanarPose",
    "PointCloud",
    "Prediction",
    "RecognitionPipeline",
    "RecognitionResult",
    "RectangularGrid",
    "RgbdFrame",
    "RobotSettings",
    "ScanSettings",
    "SimulatedRobot",
    "SurfaceNormalPlanner",
    "Tracker",
    "TrackingSettings",
    "Trajectory",
    "TriangleMesh",
    "Velocity",
    "WeightsError",
    "YawSweep",
    "absolute_trajectory_error",
    "angular_spectrum",
    "as_cloud",
    "camera_path",
    "cell_evidence",
    "cut_floor",
    "furniture_set",
    "make_furniture",
    "nearest_examples",
    "read_cloud",
    "read_mesh",
    "room",
    "spread_yaws",
    "sweep_yaw",
    "without_stray_points",
    "write_ply",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'circumspect' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(f"circumspect.{_HOME_OF[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
