"""The place of a gathered set: a folder, or an object store."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

from circumspect.datasets.gathered_set import (
    MANIFEST,
    SETTINGS,
    GatheredScan,
    is_gathered,
    read_manifest,
    read_settings,
    scan_of_line,
)
from circumspect.datasets.set_store import SetStore
from circumspect.errors import InputError, OutputError
from circumspect.folder_lock import NAME as LOCK
from circumspect.folder_lock import FolderLock, lock_folder
from circumspect.storage import append_line, atomic_open, write_json

SCANS = "scans"
"""Folder of an object store with a file per scan, since objects cannot be appended to."""


class SetPlace(Protocol):
    """A set to which scans are added."""

    @property
    def name(self) -> str:
        """Path or URL."""
        ...

    def is_begun(self) -> bool:
        """Whether a set exists."""
        ...

    def begin(self, settings: Mapping[str, object]) -> None:
        """Begin an empty set.

        Raises:
            InputError: The place holds something else.
            OutputError: It cannot be written.
        """
        ...

    def settings(self) -> dict[str, Any]:
        """The settings of the set.

        Raises:
            InputError: They cannot be read.
        """
        ...

    def write_settings(self, settings: Mapping[str, object]) -> None:
        """Replace the settings.

        Raises:
            OutputError: They cannot be written.
        """
        ...

    def scans(self) -> list[GatheredScan]:
        """All scans of the set; none if no set exists.

        Raises:
            InputError: They cannot be read.
        """
        ...

    def add(self, scan: GatheredScan) -> None:
        """Add a scan whose files are complete.

        Raises:
            OutputError: It cannot be written.
        """
        ...

    def finish(self) -> None:
        """Complete the set after the last requested scan.

        Raises:
            OutputError: The manifest cannot be written.
        """
        ...

    def written(self) -> AbstractContextManager[Path]:
        """A folder for the files of scans, which enter the set when the block ends.

        Raises:
            InputError: This machine does not see the set.
            OutputError: They cannot be written.
        """
        ...

    def local(self, scans: Sequence[GatheredScan]) -> AbstractContextManager[Path]:
        """A folder with the set's manifest and the clouds of some scans.

        Raises:
            InputError: They cannot be read.
        """
        ...


def place_of(out: str | os.PathLike[str]) -> SetPlace:
    """The place that a path or URL names."""
    return SetBucket(str(out)) if "://" in str(out) else SetFolder(Path(out))


class SetFolder:
    """A set in a folder, see `SetPlace`; of a cluster all nodes must see it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock: FolderLock | None = None

    @property
    def name(self) -> str:
        """See `SetPlace.name`."""
        return str(self._folder)

    def is_begun(self) -> bool:
        """See `SetPlace.is_begun`."""
        return is_gathered(self._folder)

    def begin(self, settings: Mapping[str, object]) -> None:
        """See `SetPlace.begin`."""
        self.require_free()
        self._claim()
        self.write_settings(settings)
        with atomic_open(self._folder / MANIFEST) as stream:
            stream.write("")

    def require_free(self) -> None:
        """Check that a set can begin here.

        Raises:
            InputError: The folder holds something else.
        """
        if self._folder.exists() and not _is_free(self._folder):
            raise InputError(f"{self._folder}: holds something else; give an empty or a new folder")

    def settings(self) -> dict[str, Any]:
        """See `SetPlace.settings`."""
        self._claim()
        return read_settings(self._folder)

    def _claim(self) -> None:
        """Lock the set against other writers.

        Raises:
            OutputError: One does.
        """
        self._lock = self._lock or lock_folder(self._folder)

    def write_settings(self, settings: Mapping[str, object]) -> None:
        """See `SetPlace.write_settings`."""
        write_json(self._folder / SETTINGS, dict(settings))

    def scans(self) -> list[GatheredScan]:
        """See `SetPlace.scans`."""
        return read_manifest(self._folder) if self.is_begun() else []

    def add(self, scan: GatheredScan) -> None:
        """See `SetPlace.add`."""
        self._claim()
        append_line(self._folder / MANIFEST, scan.line().rstrip("\n"), durable=True)

    def finish(self) -> None:
        """See `SetPlace.finish`; the manifest is complete."""

    @contextmanager
    def written(self) -> Iterator[Path]:
        """See `SetPlace.written`."""
        if not (self._folder / SETTINGS).is_file():
            raise InputError(
                f"{self._folder}: can not be seen from {socket.gethostname()}; give a folder that "
                "all nodes share, or the URL of an object store"
            )
        yield self._folder

    @contextmanager
    def local(self, scans: Sequence[GatheredScan]) -> Iterator[Path]:  # noqa: ARG002 - all are here
        """See `SetPlace.local`."""
        yield self._folder


def _is_free(folder: Path) -> bool:
    """Whether it is empty, or holds only the settings of a set that was interrupted at once."""
    if not folder.is_dir():
        return False
    names = [file.name for file in folder.iterdir() if file.name != LOCK]
    if names == [SETTINGS]:
        return bool(read_settings(folder).keys() & {"version", "source"})
    return not names


class SetBucket:
    """A set in an object store, see `SetPlace`.

    Args:
        url: Such as s3://bucket/set.

    Raises:
        MissingExtraError: fsspec, or what it needs for such a URL, is not installed.
        InputError: No such kind of URL is known.
    """

    def __init__(self, url: str) -> None:
        self._store = SetStore(url)

    @property
    def name(self) -> str:
        """See `SetPlace.name`."""
        return self._store.url

    def is_begun(self) -> bool:
        """See `SetPlace.is_begun`."""
        return bool(self._store.names(SETTINGS))

    def begin(self, settings: Mapping[str, object]) -> None:
        """See `SetPlace.begin`."""
        if found := self._store.names("*"):
            raise InputError(f"{self._store.place(found[0])}: is of something else; give a new URL")
        self.write_settings(settings)

    def settings(self) -> dict[str, Any]:
        """See `SetPlace.settings`."""
        try:
            found = json.loads(self._store.read(SETTINGS))
        except (ValueError, RecursionError) as error:
            raise self._broken(SETTINGS) from error
        if not isinstance(found, dict):
            raise self._broken(SETTINGS)
        return found

    def _broken(self, name: str) -> InputError:
        return InputError(f"{self._store.place(name)}: is of no gathered set")

    def write_settings(self, settings: Mapping[str, object]) -> None:
        """See `SetPlace.write_settings`."""
        self._store.write(SETTINGS, json.dumps(dict(settings), indent=2).encode())

    def scans(self) -> list[GatheredScan]:
        """See `SetPlace.scans`; in the order of their names."""
        return [
            scan_of_line(self._store.read(name).decode(errors="replace"), self._store.place(name))
            for name in self._store.names(f"{SCANS}/*.json")
        ]

    def add(self, scan: GatheredScan) -> None:
        """See `SetPlace.add`."""
        self._store.write(f"{SCANS}/{scan.scan}.json", scan.line().encode())

    def finish(self) -> None:
        """See `SetPlace.finish`: put all scans into one manifest."""
        lines = "".join(scan.line() for scan in self.scans())
        self._store.write(MANIFEST, lines.encode())

    @contextmanager
    def written(self) -> Iterator[Path]:
        """See `SetPlace.written`."""
        with TemporaryDirectory() as name:
            folder = Path(name)
            yield folder
            for file in sorted(path for path in folder.rglob("*") if path.is_file()):
                self._store.write(file.relative_to(folder).as_posix(), file.read_bytes())

    @contextmanager
    def local(self, scans: Sequence[GatheredScan]) -> Iterator[Path]:
        """See `SetPlace.local`."""
        with TemporaryDirectory() as name:
            folder = Path(name)
            for one in (SETTINGS, *(scan.files["cloud"] for scan in scans)):
                file = folder / one
                file.parent.mkdir(exist_ok=True)
                try:
                    file.write_bytes(self._store.read(one))
                except OSError as error:
                    raise OutputError(f"{file}: can not be written ({error})") from error
            (folder / MANIFEST).write_text("".join(scan.line() for scan in scans))
            yield folder
