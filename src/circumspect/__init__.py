"""circumspect: name an object from any side.

Names are imported when first used, so that `import circumspect` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from circumspect.classification import Classifier as Classifier
    from circumspect.classification import GridRecipe as GridRecipe
    from circumspect.classification import Prediction as Prediction
    from circumspect.errors import CircumspectError as CircumspectError
    from circumspect.errors import GeometryError as GeometryError
    from circumspect.errors import InputError as InputError
    from circumspect.errors import MissingExtraError as MissingExtraError
    from circumspect.errors import OutputError as OutputError
    from circumspect.errors import WeightsError as WeightsError
    from circumspect.furniture import make_furniture as make_furniture
    from circumspect.geometry import PinholeCamera as PinholeCamera
    from circumspect.geometry import PointCloud as PointCloud
    from circumspect.geometry import Trajectory as Trajectory
    from circumspect.geometry import TriangleMesh as TriangleMesh
    from circumspect.geometry import cut_floor as cut_floor
    from circumspect.geometry import read_cloud as read_cloud
    from circumspect.geometry import read_mesh as read_mesh
    from circumspect.geometry import without_stray_points as without_stray_points
    from circumspect.geometry import write_ply as write_ply
    from circumspect.grid import CylindricalGrid as CylindricalGrid
    from circumspect.grid import OccupancyGrid as OccupancyGrid
    from circumspect.grid import RectangularGrid as RectangularGrid
    from circumspect.grid import angular_spectrum as angular_spectrum
    from circumspect.recognition import RecognitionPipeline as RecognitionPipeline
    from circumspect.reconstruction import ObjectModel as ObjectModel
    from circumspect.sensing import Odometry as Odometry
    from circumspect.sensing import RgbdFrame as RgbdFrame

__version__ = "0.1.0"

_HOMES = {
    "classification": ("Classifier", "GridRecipe", "Prediction"),
    "errors": (
        "CircumspectError",
        "GeometryError",
        "InputError",
        "MissingExtraError",
        "OutputError",
        "WeightsError",
    ),
    "furniture": ("make_furniture",),
    "geometry": (
        "PinholeCamera",
        "PointCloud",
        "Trajectory",
        "TriangleMesh",
        "cut_floor",
        "read_cloud",
        "read_mesh",
        "without_stray_points",
        "write_ply",
    ),
    "grid": ("CylindricalGrid", "OccupancyGrid", "RectangularGrid", "angular_spectrum"),
    "recognition": ("RecognitionPipeline",),
    "reconstruction": ("ObjectModel",),
    "sensing": ("Odometry", "RgbdFrame"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "CircumspectError",
    "Classifier",
    "CylindricalGrid",
    "GeometryError",
    "GridRecipe",
    "InputError",
    "MissingExtraError",
    "ObjectModel",
    "OccupancyGrid",
    "Odometry",
    "OutputError",
    "PinholeCamera",
    "PointCloud",
    "Prediction",
    "RecognitionPipeline",
    "RectangularGrid",
    "RgbdFrame",
    "Trajectory",
    "TriangleMesh",
    "WeightsError",
    "angular_spectrum",
    "cut_floor",
    "make_furniture",
    "read_cloud",
    "read_mesh",
    "without_stray_points",
    "write_ply",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'circumspect' has no attribute '{name}'")
    return getattr(import_module(f"circumspect.{_HOME_OF[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
