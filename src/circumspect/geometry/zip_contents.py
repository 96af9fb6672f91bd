"""What a ZIP archive is: several formats are archives with a rule about their members."""

from __future__ import annotations

import zipfile
from pathlib import Path

from circumspect.errors import InputError

_MAX_MEMBERS_SHOWN = 3


def format_of_zip(path: Path) -> str:
    """The suffix of the format that an archive holds: ".npz" or ".usdz".

    Raises:
        InputError: Another archive; the message says which.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names = [item.filename for item in archive.infolist()]
    except (zipfile.BadZipFile, ValueError, OverflowError, NotImplementedError) as error:
        if path.suffix.lower() in (".npz", ".usdz"):
            return path.suffix.lower()  # Its reader says what is wrong.
        raise InputError(f"is a broken ZIP archive ({error}); copy it again") from error
    if path.suffix.lower() == ".npz" or any(name.endswith(".npy") for name in names):
        return ".npz"
    if names and names[0].lower().endswith((".usd", ".usda", ".usdc")):
        return ".usdz"
    if any(name.lower().endswith(".model") for name in names):
        raise InputError("is a 3MF file, which is not read; export it as STL, PLY or GLB")
    shown = ", ".join(names[:_MAX_MEMBERS_SHOWN]) or "nothing"
    others = f" and {len(names) - _MAX_MEMBERS_SHOWN} more" if len(names) > 3 else ""
    raise InputError(f"is a ZIP archive of {shown}{others}; unpack it first")
