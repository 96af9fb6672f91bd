"""The cache folder of derived data."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder(subject: str) -> Path:
    """`$CIRCUMSPECT_CACHE/subject`, or a folder in the user's cache folder if it is not set."""
    base = os.environ.get("CIRCUMSPECT_CACHE")
    if base is None:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        base = Path(home) / "circumspect"
    return Path(base) / subject
