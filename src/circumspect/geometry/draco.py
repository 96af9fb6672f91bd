"""Meshes compressed with Draco, by DracoPy (extra `formats`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError, MissingExtraError


def decode_draco(content: bytes, position_id: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Decode a mesh.

    Args:
        content: The compressed bytes.
        position_id: Draco's unique id of the attribute that holds the positions.

    Returns:
        (n, 3) points and (f, 3) indices.

    Raises:
        InputError: Broken, or without that attribute.
        MissingExtraError: DracoPy is not installed.
    """
    try:
        import DracoPy
    except ImportError as error:
        raise MissingExtraError("DracoPy, which decodes Draco,", "formats") from error
    try:
        mesh = DracoPy.decode(content)
        attribute = mesh.get_attribute_by_unique_id(position_id)
        faces = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
    except MemoryError:
        raise
    except Exception as error:  # Whatever the decoder raises for broken data.
        raise InputError(f"has broken Draco data ({str(error)[:80]}); export it again") from error
    points = None if attribute is None else np.asarray(attribute["data"], np.float64)
    if points is None or points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"has Draco data without positions (attribute {position_id})")
    if len(faces) and not 0 <= faces.min() <= faces.max() < len(points):
        raise InputError("has Draco data with faces that name no vertex")
    return points, faces
