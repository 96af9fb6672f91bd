"""A file that holds whole records only."""

from __future__ import annotations

import os
from pathlib import Path


class WholeFile:
    """Gathers what is written, and appends it to the file when told to.

    What can not be appended as a whole is cut off again.
    """

    def __init__(self, path: Path) -> None:
        """Make a new file.

        Raises:
            OSError: It exists or can not be made.
        """
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
        self._size = 0
        self._pending = bytearray()
        self.closed = False

    def write(self, data: bytes) -> int:
        """Gather bytes."""
        self._pending += data
        return len(data)

    def tell(self) -> int:
        """Size of the file with what is gathered."""
        return self._size + len(self._pending)

    def flush(self) -> None:
        """Nothing: see `keep`."""

    def keep(self) -> None:
        """Append what was gathered.

        What is interrupted, by Ctrl-C for instance, can be kept once more.

        Raises:
            OSError: The system refuses; the file is as it was, and closed.
        """
        rest = memoryview(self._pending)
        try:
            while len(rest):
                rest = rest[os.write(self._file, rest) :]
        except BaseException as error:
            os.ftruncate(self._file, self._size)
            os.lseek(self._file, self._size, os.SEEK_SET)
            if isinstance(error, OSError):
                self.close()
            raise
        finally:
            rest.release()
        self._size += len(self._pending)
        self._pending.clear()

    def sync(self) -> None:
        """Wait until the disk has what was kept.

        Raises:
            OSError: It has not.
        """
        os.fsync(self._file)

    def close(self) -> None:
        """Let go of the file; what is gathered and not kept is lost."""
        if not self.closed:
            self.closed = True
            os.close(self._file)
