"""ModelNet10 from the public archive, as a folder of OFF files."""

from __future__ import annotations

import hashlib
import lzma
import re
import shutil
import tempfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

from circumspect.datasets.resumed_download import ResumedDownload
from circumspect.errors import CircumspectError, InputError, MissingExtraError, printable, reason_of

URL = "http://3dvision.princeton.edu/projects/2014/3DShapeNets/ModelNet10.zip"
ARCHIVE = "ModelNet10.zip"
MEMBER = re.compile(r"ModelNet10/(\w+)/(train|test)/(\w+)\.off")
"""What is unpacked; archives hold notes of the machine that made them as well."""
SHA256 = re.compile(r"[0-9a-fA-F]{64}")
UNSOUND = (BadZipFile, zlib.error, lzma.LZMAError, EOFError, RuntimeError, UnicodeDecodeError)
"""What broken archives raise, encrypted ones, those that are packed in an unknown way, and those
with names that are no text."""


def fetch_modelnet10(
    folder: Path,
    url: str = URL,
    sha256: str | None = None,
    downloader: ResumedDownload | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Download and unpack; what is there is left as it is, and an archive is not fetched again.

    An empty folder counts as not there. An interrupted download goes on where it was. The archive
    has no published checksum; each file in it has one, and is checked when it is unpacked.

    Args:
        folder: Gets the folder `ModelNet10`; the archive is not kept.
        url: Of the archive.
        sha256: What the archive must hash to, where it is known.
        downloader: Fetches; None means one beside the folder.
        progress: Called with (bytes there, bytes in all).

    Returns:
        The folder of OFF files.

    Raises:
        InputError: The checksum is none.
        MissingExtraError: pooch is not installed.
        CircumspectError: The server, the archive or the disk fails; the message says which.
    """
    if sha256 is not None and not SHA256.fullmatch(sha256):
        raise InputError(f"sha256 '{printable(sha256)}': is no checksum; give its 64 hex digits")
    target, archive = folder / "ModelNet10", folder / ARCHIVE
    if target.exists() and not _is_empty(target):
        return target
    if not archive.exists():
        part = folder / f"{ARCHIVE}.part"
        _download(url, archive, sha256, downloader or ResumedDownload(part, progress=progress))
    elif sha256 is not None:
        _require_sum(archive, sha256)
    try:
        _unpack(archive, target)
    except UNSOUND as error:
        raise _refused(archive, url, error) from error
    except OSError as error:
        # Packed by bzip2 they are broken without a number of the system's.
        if error.errno is None:
            raise _refused(archive, url, error) from error
        raise CircumspectError(
            f"{folder}: the disk failed while {ARCHIVE} was unpacked ({reason_of(error)}); the "
            "archive stays for the next attempt"
        ) from error
    archive.unlink()
    return target


def _is_empty(target: Path) -> bool:
    """A folder that was made in advance; the one that is unpacked takes its place."""
    # No folder can be renamed to a link's place.
    return target.is_dir() and not target.is_symlink() and not any(target.iterdir())


def _refused(archive: Path, url: str, error: Exception) -> CircumspectError:
    """Nobody needs it any more."""
    archive.unlink(missing_ok=True)
    return CircumspectError(
        f"{url}: what came is no sound archive ({error}); fetch it again, or from elsewhere"
    )


def _require_sum(archive: Path, sha256: str) -> None:
    """Of an archive that an earlier attempt left."""
    try:
        with archive.open("rb") as stream:
            found = hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise CircumspectError(f"{archive}: can not be read ({reason_of(error)})") from error
    if found != sha256.lower():
        raise CircumspectError(
            f"{archive}: is there already, but does not have the checksum {sha256}; remove it to "
            "fetch it anew"
        )


def _download(url: str, archive: Path, sha256: str | None, downloader: ResumedDownload) -> None:
    try:
        import pooch
    except ImportError as error:
        raise MissingExtraError("pooch", "data") from error
    pooch.get_logger().setLevel("ERROR")
    fetches: Any = downloader  # pooch names the same arguments otherwise
    known = None if sha256 is None else f"sha256:{sha256.lower()}"
    try:
        pooch.retrieve(url, known, archive.name, archive.parent, downloader=fetches)
    except ValueError as error:
        if sha256 is None:
            raise
        raise CircumspectError(
            f"{url}: what came does not have the checksum {sha256}; fetch it from elsewhere"
        ) from error
    except OSError as error:
        raise CircumspectError(
            f"{archive.parent}: can not be written ({reason_of(error)})"
        ) from error


def _unpack(archive: Path, target: Path) -> None:
    """Beside the target first, so that it is whole when it appears."""
    with ZipFile(archive) as members:
        wanted = [entry for entry in members.infolist() if MEMBER.fullmatch(entry.filename)]
        if not wanted:
            raise BadZipFile("it holds no ModelNet10/<class>/<split>/*.off")
        room, free = sum(e.file_size for e in wanted), shutil.disk_usage(target.parent).free
        if room > free:
            raise CircumspectError(
                f"{target.parent}: {room / 1e6:,.0f} MB are to be unpacked, but there is room for "
                f"{free / 1e6:,.0f} MB; the archive stays for the next attempt"
            )
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".unpacking") as aside:
            for entry in wanted:
                members.extract(entry, aside)
            (Path(aside) / "ModelNet10").replace(target)
