"""Files of a folder that may hold anything: a pipe never ends, or never begins."""

from __future__ import annotations

from pathlib import Path


def require_regular(file: Path) -> None:
    """Refuse devices, pipes and sockets; folders and missing files are told by who opens them.

    Raises:
        OSError: It is there, but no regular file.
    """
    if file.exists() and not file.is_file() and not file.is_dir():
        raise OSError("not a regular file")
