"""Models of a Sweet Home 3D catalogue in metres, z up, as the program places them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.packed_mesh import PackedMesh
from circumspect.datasets.sweethome3d_catalogue import Piece, PieceError, SkipCode
from circumspect.errors import InputError
from circumspect.geometry import TriangleMesh
from circumspect.geometry.obj_file import parse_obj

SIDES = ("width", "depth", "height")
LARGEST_METRES = 1000.0
"""Of a side; the largest trucks and pools have 20."""
ROTATION_TOLERANCE = 0.01
"""Catalogues give rotations with a few digits."""

# The program's x points to the right, y up and z to the viewer; here the front faces -y.
_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def size_of(piece: Piece) -> tuple[float, float, float]:
    """Width, depth and height [m].

    Raises:
        PieceError: One is missing, no number, not positive or too large.
    """
    width, depth, height = (_side(piece, side) for side in SIDES)
    return width, depth, height


def rotation_of(piece: Piece) -> NDArray[np.float64]:
    """(3, 3) how the model is turned before it is scaled, in the program's axes.

    Raises:
        PieceError: It is given, but is no rotation.
    """
    text = piece.properties.get("modelRotation", "").strip()
    if not text:
        return np.eye(3)
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = []
    rotation = np.array(numbers).reshape(3, 3) if len(numbers) == 9 else np.zeros((3, 3))
    if not _is_rotation(rotation):
        raise PieceError(SkipCode.BAD_ROTATION, "its modelRotation is no rotation of nine numbers")
    return rotation


def placed_model(
    data: bytes, metres: tuple[float, float, float], rotation: NDArray[np.float64]
) -> PackedMesh:
    """The mesh of an OBJ file, turned and scaled as the properties say.

    Args:
        data: The file.
        metres: Width, depth and height [m] of the result.
        rotation: (3, 3) in the program's axes.

    Returns:
        The mesh: z up, standing on z = 0, centred on the z axis, front towards -y. A side without
        extent stays so.

    Raises:
        PieceError: The file is broken, or holds no surface.
    """
    try:
        return _packed(data, np.array(metres), _Z_UP @ rotation)
    except InputError as error:
        reason = str(error).removeprefix("the mesh ")
        raise PieceError(SkipCode.BROKEN_MODEL, f"its model {reason}") from error


def _packed(data: bytes, metres: NDArray[np.float64], rotation: NDArray[np.float64]) -> PackedMesh:
    # Coordinates may be of any size.
    with np.errstate(all="ignore"):
        shape = parse_obj(data)
        faces = np.empty((0, 3), np.int64) if shape.faces is None else shape.faces
        if len(faces) == 0:
            raise InputError("has no faces")
        used, renumbered = np.unique(faces, return_inverse=True)
        vertices = _scaled(shape.points_xyz[used] @ rotation.T, metres)
        mesh = TriangleMesh(vertices, renumbered.reshape(-1, 3))
        mesh.chosen_by_area(1)
        return PackedMesh.from_mesh(mesh)


def _scaled(vertices_xyz: NDArray[np.float64], metres: NDArray[np.float64]) -> NDArray[np.float64]:
    low, high = vertices_xyz.min(axis=0), vertices_xyz.max(axis=0)
    extent = high - low
    if not np.isfinite(extent).all():
        raise InputError("has coordinates that are not finite")
    # Of a side without extent all is 0.
    shares = (vertices_xyz - low) / np.where(extent > 0, extent, 1)
    middle = np.where(extent > 0, metres / 2, 0) * [1, 1, 0]
    return shares * metres - middle


def _side(piece: Piece, side: str) -> float:
    text = piece.properties.get(side, "").strip()
    if not text:
        raise PieceError(SkipCode.BAD_SIZE, f"has no {side}")
    try:
        metres = float(text) / 100
    except ValueError:
        metres = math.nan
    if not 0 < metres <= LARGEST_METRES:
        raise PieceError(SkipCode.BAD_SIZE, f"its {side} is no usable number of centimetres")
    return metres


def _is_rotation(matrix: NDArray[np.float64]) -> bool:
    return bool(
        np.allclose(matrix @ matrix.T, np.eye(3), rtol=0, atol=ROTATION_TOLERANCE)
        and np.linalg.det(matrix) > 0
    )
