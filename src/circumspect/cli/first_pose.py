"""Whether `--first-pose` can be where a camera was."""

from __future__ import annotations

from circumspect.errors import InputError

HIGHEST = 10.0
"""Of a camera above the floor [m]; what is given beyond is in millimetres."""


def require_above_floor(z: float) -> None:
    """A camera that stands on the floor's upper side.

    Args:
        z: Its height above the floor [m].

    Raises:
        InputError: It does not.
    """
    if not 0 < z <= HIGHEST:
        raise InputError(
            f"--first-pose: a camera {z:g} m above the floor; give Z in metres, above 0 and at "
            f"most {HIGHEST:g}, or the object's --box"
        )
