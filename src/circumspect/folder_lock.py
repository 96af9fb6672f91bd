"""A lock for a folder with one writing run."""

from __future__ import annotations

import fcntl
import os
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from circumspect.errors import OutputError, reason_of
from circumspect.storage import remove_abandoned

NAME = ".lock"
"""Name of the locked file. The kernel releases the lock when the process ends in any way."""

_held: weakref.WeakValueDictionary[tuple[int, int], FolderLock] = weakref.WeakValueDictionary()
"""Locks of this process, by device and inode."""


class FolderLock:
    """Excludes other processes from writing to a folder as long as it is referenced."""


def lock_folder(folder: Path) -> FolderLock:
    """Lock a folder, and remove temporary files of a killed run.

    Args:
        folder: Made if missing.

    Returns:
        The lock; the same one for all callers in this process.

    Raises:
        OutputError: Another process holds it, or the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file, key = _opened(folder)
    except OSError as error:
        raise OutputError(f"{folder}: can not be written ({reason_of(error)})") from error
    if file is None:
        return _held[key]
    lock = _held[key] = FolderLock()
    weakref.finalize(lock, _release, folder.absolute() / NAME, file, os.getpid())
    remove_abandoned(folder)
    return lock


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """Lock a folder while a block runs.

    Args:
        folder: As for `lock_folder`.

    Raises:
        OutputError: As from `lock_folder`.
    """
    lock = lock_folder(folder)
    try:
        yield
    finally:
        # A stored exception keeps its frames, which would keep the lock.
        del lock


def _opened(folder: Path) -> tuple[int | None, tuple[int, int]]:
    """The locked file, or None if this process holds it already, and its key."""
    while True:
        file = os.open(folder / NAME, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        key = _key(os.fstat(file))
        if key in _held:
            os.close(file)
            return None, key
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            os.close(file)
            raise OutputError(
                f"{folder}: another run writes to it; wait for its end or take another folder"
            ) from error
        except OSError:
            pass  # A file system without locks.
        # The former holder may have removed it meanwhile: then the lock is on no file.
        with suppress(FileNotFoundError):
            if _key((folder / NAME).stat()) == key:
                return file, key
        os.close(file)


def _key(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino


def _release(path: Path, file: int, owner: int) -> None:
    # A forked process has a copy of the lock, and must not end its owner's run.
    if os.getpid() == owner:
        with suppress(OSError):
            path.unlink()
    os.close(file)
