"""Point clouds, meshes and their files, the pinhole camera, trajectories and SE(3)."""

from circumspect.geometry.camera import PinholeCamera
from circumspect.geometry.clusters import without_stray_points
from circumspect.geometry.floor_cut import FloorCut, cut_floor
from circumspect.geometry.formats import read_cloud, read_mesh, read_tum, write_ply, write_tum
from circumspect.geometry.given_shapes import as_cloud
from circumspect.geometry.planar_pose import PlanarPose, wrapped
from circumspect.geometry.point_cloud import PointCloud, require_extent
from circumspect.geometry.surface import fill_surface, short_edge_triangles
from circumspect.geometry.trajectory import Trajectory, TrajectoryLog
from circumspect.geometry.triangle_mesh import TriangleMesh

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
