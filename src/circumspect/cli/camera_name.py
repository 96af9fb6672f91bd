"""Which camera `locate intrinsics` and `locate extrinsics` calibrate."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from circumspect.errors import InputError


def folder_camera(files: Iterable[Path]) -> str:
    """The camera's name, where only the images' folder tells it.

    Args:
        files: The images.

    Raises:
        InputError: They lie in folders of different names.
    """
    names = sorted({file.absolute().parent.name for file in files})
    if len(names) > 1:
        raise InputError(
            f"images from {len(names)} folders, {' and '.join(names[:2])}: a camera at a time; if "
            "they are all of one, name it by --camera"
        )
    return names[0]
