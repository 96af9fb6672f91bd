"""One run at a time writes to a folder."""

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
"""Of the file that is locked. The kernel lets go of it when a process dies, however that ends."""

_held: weakref.WeakValueDictionary[tuple[int, int], FolderLock] = weakref.WeakValueDictionary()
"""Locks of this process, by device and number of the file."""


class FolderLock:
    """Keeps other processes from writing a run to a folder, for as long as it is referred to."""


def lock_folder(folder: Path) -> FolderLock:
    """Lock a folder, and remove temporary files that a killed run left in it.

    Args:
        folder: Made where missing.

    Returns:
        The lock; the same one for all who ask in this process.

    Raises:
        OutputError: Another process holds it, or the folder can not be written.
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
        # Whoever keeps an exception keeps the frame that it passed, and would keep the lock.
        del lock


def _opened(folder: Path) -> tuple[int | None, tuple[int, int]]:
    """The locked file, None where this process holds it already, and what it is known by."""
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
        # Whoever held it may have removed it meanwhile: then the lock is one of no file.
        with suppress(FileNotFoundError):
            if _key((folder / NAME).stat()) == key:
                return file, key
        os.close(file)


def _key(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino


def _release(path: Path, file: int, owner: int) -> None:
    # A forked process has a copy of the lock, and does not end its owner's run.
    if os.getpid() == owner:
        with suppress(OSError):
            path.unlink()
    os.close(file)
