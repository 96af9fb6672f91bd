"""Readers and writers of mesh, point cloud and trajectory files, one module per format."""

from circumspect.geometry.formats.cloud_files import read_cloud, read_mesh
from circumspect.geometry.formats.ply_file import write_ply
from circumspect.geometry.formats.tum_file import read_tum, write_tum

__all__ = ["read_cloud", "read_mesh", "read_tum", "write_ply", "write_tum"]
