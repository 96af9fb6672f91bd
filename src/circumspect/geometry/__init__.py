"""Shapes and poses: point clouds, meshes, files of both, the pinhole camera, trajectories."""

from circumspect.geometry.camera import PinholeCamera
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.triangle_mesh import TriangleMesh

__all__ = ["PinholeCamera", "PointCloud", "TriangleMesh"]
