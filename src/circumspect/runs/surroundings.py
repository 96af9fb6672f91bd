"""Walls and clutter around the object, for playback and dashboard."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry.formats.npy_stream import read_arrays
from circumspect.simulation import GroundTruthRecorder, Scene
from circumspect.storage import atomic_open

LEFT_OUT = ("object", "floor")
WALL = "wall"
KINDS = {"vertices_xyz": "f", "faces": "i", "colours": "f", "counts": "i"}
MAX_ARRAY_BYTES = 16 << 20
"""Maximum size of all arrays of a file [bytes]."""


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """A wall or a piece of clutter.

    Attributes:
        vertices_xyz: (v, 3) float32 [m].
        faces: (f, 3) int32 indices of vertices.
        colour: (3,) RGB, each 0 … 1.
        wall: Whether it is a wall.
    """

    vertices_xyz: NDArray[np.float32]
    faces: NDArray[np.int32]
    colour: NDArray[np.float32]
    wall: bool


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Everything except the object and the floor.

    Attributes:
        meshes: Walls and pieces of clutter.
    """

    meshes: tuple[SolidMesh, ...] = ()

    @classmethod
    def of(cls, scene: Scene, T_map_scene: RigidTransform) -> Surroundings:
        """The surroundings in a simulated scene.

        Args:
            scene: The scene.
            T_map_scene: Pose of the scene in the robot's map.
        """
        meshes = (
            SolidMesh(
                T_map_scene.apply(surface.mesh.vertices_xyz).astype(np.float32),
                np.asarray(surface.mesh.faces, np.int32),
                np.asarray(surface.colour, np.float32),
                surface.name.startswith(WALL),
            )
            for surface in scene.surfaces
            if surface.name not in LEFT_OUT
        )
        return cls(tuple(meshes))

    @classmethod
    def with_ground_truth(
        cls, scene: Scene, ground_truth: GroundTruthRecorder, T_map_camera: RigidTransform
    ) -> Surroundings:
        """The surroundings in a scene that the robot's true pose aligns with its map.

        Args:
            scene: The scene.
            ground_truth: Recorder with the true pose of the latest frame.
            T_map_camera: Estimated pose of that frame.
        """
        return cls.of(scene, T_map_camera * ground_truth.trajectory.T_map_camera[-1].inv())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as npz.

        Raises:
            OutputError: The file cannot be written.
        """
        meshes = self.meshes
        with atomic_open(path, "wb") as stream:
            np.savez_compressed(
                stream,
                vertices_xyz=_joined([mesh.vertices_xyz for mesh in meshes], np.float32),
                faces=_joined([mesh.faces for mesh in meshes], np.int32),
                colours=_joined([mesh.colour[None] for mesh in meshes], np.float32),
                counts=np.array(
                    [(len(t.vertices_xyz), len(t.faces), t.wall) for t in meshes], np.int32
                ).reshape(-1, 3),
            )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Surroundings:
        """Read what `save` wrote.

        Raises:
            InputError: The file is missing, broken, too large, or of another kind.
        """
        arrays = read_arrays(Path(path), KINDS, MAX_ARRAY_BYTES)
        try:
            vertices, faces = arrays["vertices_xyz"], arrays["faces"]
            colours, counts = arrays["colours"], arrays["counts"]
            checks = [vertices.shape[1:] == (3,), faces.shape[1:] == (3,), counts.shape[1:] == (3,)]
            if not all(checks) or colours.shape != (len(counts), 3) or (counts < 0).any():
                raise ValueError("wrong shapes")
            if not np.isfinite(vertices).all() or not np.isfinite(colours).all():
                raise ValueError("numbers that are not finite")
            meshes, v, f = [], 0, 0
            for (more_v, more_f, wall), colour in zip(counts.tolist(), colours, strict=True):
                own = faces[f : f + more_f]
                if v + more_v > len(vertices) or f + more_f > len(faces):
                    raise ValueError("fewer numbers than announced")
                if len(own) and not 0 <= own.min() <= own.max() < more_v:
                    raise ValueError("faces of vertices that are not there")
                meshes.append(SolidMesh(vertices[v : v + more_v], own, colour, bool(wall)))
                v, f = v + more_v, f + more_f
        except (KeyError, ValueError, IndexError) as error:
            raise InputError(f"{path}: no surroundings ({error})") from error
        return cls(tuple(meshes))


def _joined(arrays: list[NDArray], dtype: type[np.generic]) -> NDArray:
    return np.concatenate([np.empty((0, 3)), *arrays]).astype(dtype)
