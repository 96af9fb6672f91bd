"""Objects far from the origin are read exactly or refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from circumspect.errors import GeometryError
from circumspect.furniture import make_furniture
from circumspect.geometry import read_cloud, read_mesh

SURVEY = np.array([500_000.0, 4_500_000.0, 100.0])
"""Easting, northing, height [m]."""


def far_chair() -> np.ndarray:
    return make_furniture("chair", 3).sampled(2000, 0).points_xyz + SURVEY


@pytest.mark.parametrize("name", ["a.npy", "a.npz"])
def test_a_cloud_lost_to_single_precision_is_refused(name: str, tmp_path: Path):
    points = far_chair().astype(np.float32)
    file = tmp_path / name
    if name.endswith("npy"):
        np.save(file, points)
    else:
        np.savez(file, points=points)
    with pytest.raises(
        GeometryError, match=r"4.5e.06 away from the origin.* steps of 0.5; subtract"
    ):
        read_cloud(file)


def test_a_mesh_lost_to_single_precision_is_refused(tmp_path: Path):
    chair = make_furniture("chair", 3)
    trimesh.Trimesh(chair.vertices_xyz + SURVEY, chair.faces).export(tmp_path / "a.stl")
    for read in (read_mesh, read_cloud):
        with pytest.raises(GeometryError, match="single precision"):
            read(tmp_path / "a.stl")


def test_double_precision_far_from_the_origin_is_exact(tmp_path: Path):
    np.save(tmp_path / "a.npy", far_chair())
    np.testing.assert_array_equal(read_cloud(tmp_path / "a.npy").points_xyz, far_chair())


@pytest.mark.parametrize("scale", [1e-30, 1e-3, 1.0, 1e3, 1e30])
def test_single_precision_suffices_near_the_origin(scale: float, tmp_path: Path):
    points = ((far_chair() - SURVEY + [3.0, -50.0, 1.0]) * scale).astype(np.float32)
    np.save(tmp_path / "a.npy", points)
    np.testing.assert_array_equal(read_cloud(tmp_path / "a.npy").points_xyz, points)
