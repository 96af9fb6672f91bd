"""What callers hand over where a rigid transform is wanted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from circumspect.errors import InputError

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform


def require_transform(given: object, name: str) -> RigidTransform:
    """One pose, or a batch of them, as SciPy's `RigidTransform`.

    Args:
        given: Of any type.
        name: What the caller calls it.

    Raises:
        InputError: It is of another type, such as a (4, 4) matrix.
    """
    from scipy.spatial.transform import RigidTransform

    if isinstance(given, RigidTransform):
        return given
    raise InputError(
        f"{name} must be a SciPy RigidTransform, not {type(given).__name__}; a (4, 4) matrix "
        "becomes one by RigidTransform.from_matrix, a PlanarPose by as_transform"
    )
