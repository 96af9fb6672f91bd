"""Storage of a large set's files in a folder or an object store."""

from __future__ import annotations

import os
from typing import IO, Any

from circumspect.errors import InputError, MissingExtraError, OutputError
from circumspect.storage import atomic_open


class SetStore:
    """Files below a root, by names with slashes.

    Args:
        url: A path, or a URL that fsspec supports, such as s3://bucket/set.

    Raises:
        MissingExtraError: fsspec, or a package that it needs for the URL, is not installed.
        InputError: The kind of URL is unknown.
    """

    def __init__(self, url: str | os.PathLike[str]) -> None:
        try:
            import fsspec
        except ImportError as error:
            raise MissingExtraError("fsspec", "cluster") from error
        self.url = os.fspath(url)
        try:
            files, root = fsspec.core.url_to_fs(self.url)
        except (ValueError, ImportError) as error:
            raise InputError(f"{self.url}: can not be opened ({error})") from error
        self._files: Any = files
        self._root = str(root).rstrip("/")
        self._is_local = "file" in self._files.protocol

    def place(self, name: str) -> str:
        """The full path or URL of a file, for messages."""
        return f"{self.url.rstrip('/')}/{name}"

    def names(self, pattern: str) -> list[str]:
        """Names of the files that match, in alphabetical order.

        Args:
            pattern: Name with * for any name within a folder.

        Raises:
            InputError: The store cannot be reached.
        """
        try:
            # An object store may have cached an earlier answer.
            self._files.invalidate_cache()
            found = self._files.glob(f"{self._root}/{pattern}")
        except OSError as error:
            raise InputError(f"{self.url}: can not be read ({error})") from error
        start = len(self._root) + 1
        return sorted(path[start:] for path in found)

    def opened(self, name: str) -> IO[bytes]:
        """Open a file for reading; the caller closes it.

        Raises:
            InputError: It is missing or cannot be read.
        """
        try:
            return self._files.open(f"{self._root}/{name}", "rb")
        except OSError as error:
            raise InputError(f"{self.place(name)}: can not be read ({error})") from error

    def read(self, name: str) -> bytes:
        """Read a whole file.

        Raises:
            InputError: It is missing or cannot be read.
        """
        try:
            return self._files.cat_file(f"{self._root}/{name}")
        except OSError as error:
            raise InputError(f"{self.place(name)}: can not be read ({error})") from error

    def write(self, name: str, content: bytes) -> None:
        """Write a whole file atomically.

        Raises:
            OutputError: It cannot be written.
        """
        path = f"{self._root}/{name}"
        if self._is_local:
            with atomic_open(path, "wb") as stream:
                stream.write(content)
            return
        try:
            # Object stores show an object only when it is complete.
            self._files.pipe_file(path, content)
        except OSError as error:
            raise OutputError(f"{self.place(name)}: can not be written ({error})") from error
