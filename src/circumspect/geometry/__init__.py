"""Shapes and poses: point clouds, meshes and their files, pinhole camera, trajectories, SE(3)."""

from circumspect.geometry.angles import wrapped
from circumspect.geometry.camera import PinholeCamera
from circumspect.geometry.cloud_files import read_cloud, read_mesh
from circumspect.geometry.extent import require_extent
from circumspect.geometry.floor_cut import FloorCut, cut_floor
from circumspect.geometry.given_cloud import as_cloud
from circumspect.geometry.planar_pose import PlanarPose
from circumspect.geometry.ply_file import write_ply
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.stray_points import without_stray_points
from circumspect.geometry.surface import fill_surface, short_edge_triangles
from circumspect.geometry.trajectory import Trajectory
from circumspect.geometry.trajectory_log import TrajectoryLog
from circumspect.geometry.triangle_mesh import TriangleMesh
from circumspect.geometry.tum_file import read_tum, write_tum

__all__ = [
    "FloorCut",
    "PinholeCamera",
    "PlanarPose",
    "PointCloud",
    "Trajectory",
    "TrajectoryLog",
    "TriangleMesh",
    "as_cloud",
    "cut_floor",
    "fill_surface",
    "read_cloud",
    "read_mesh",
    "read_tum",
    "require_extent",
    "short_edge_triangles",
    "without_stray_points",
    "wrapped",
    "write_ply",
    "write_tum",
]
