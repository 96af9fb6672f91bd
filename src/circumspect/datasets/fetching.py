"""Download of ModelNet10 from the public archive, as a folder of OFF files."""

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
URL_SHA256 = "9d8679435fc07d1d26f13009878db164a7aa8ea5e7ea3c8880e42794b7307d51"
"""SHA-256 of the archive at `URL`. Princeton publishes none; CompressAI (compressai/datasets) and
Flux3D.jl (src/datasets/modelnet/base.jl) verify this one independently of each other."""
ARCHIVE = "ModelNet10.zip"
MEMBER = re.compile(r"ModelNet10/(\w+)/(train|test)/(\w+)\.off")
"""Files that are unpacked; archives also contain system files of the machine that made them."""
SHA256 = re.compile(r"[0-9a-fA-F]{64}")
UNSOUND = (BadZipFile, zlib.error, lzma.LZMAError, EOFError, RuntimeError, UnicodeDecodeError)
"""Exceptions for archives that are broken, encrypted, packed in an unknown way, or whose file names
are not text."""


def fetch_modelnet10(
    folder: Path,
    url: str = URL,
    sha256: str | None = None,
    downloader: ResumedDownload | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Download and unpack the archive.

    Existing files are kept, and a complete archive is not fetched again. An empty folder counts as
    missing. An interrupted download resumes. The checksum of each file in the archive is verified
    as well.

    Args:
        folder: Parent of the folder `ModelNet10`; the archive is not kept.
        url: URL of the archive.
        sha256: Expected hash of the archive. Default: `URL_SHA256` for `URL`, no check for other
            URLs.
        downloader: Downloads the archive; None means a downloader that stores beside the folder.
        progress: Called with (received bytes, all bytes).

    Returns:
        The folder of OFF files.

    Raises:
        InputError: `sha256` is not a checksum.
        MissingExtraError: pooch is not installed.
        CircumspectError: The server, the archive or the disk fails; the message says which.
    """
    if sha256 is not None and not SHA256.fullmatch(sha256):
        raise InputError(f"sha256 '{printable(sha256)}': is no checksum; give its 64 hex digits")
    if sha256 is None and url == URL:
        sha256 = URL_SHA256
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
        # Archives packed by bzip2 are broken without an errno.
        if error.errno is None:
            raise _refused(archive, url, error) from error
        raise CircumspectError(
            f"{folder}: the disk failed while {ARCHIVE} was unpacked ({reason_of(error)}); the "
            "archive stays for the next attempt"
        ) from error
    archive.unlink()
    return target


def _is_empty(target: Path) -> bool:
    """Remove an existing empty folder; the unpacked one replaces it."""
    # A folder cannot be renamed to the path of a link.
    return target.is_dir() and not target.is_symlink() and not any(target.iterdir())


def _refused(archive: Path, url: str, error: Exception) -> CircumspectError:
    """Delete a broken archive and return the error to raise."""
    archive.unlink(missing_ok=True)
    return CircumspectError(
        f"{url}: what came is no sound archive ({error}); fetch it again, or from elsewhere"
    )


def _require_sum(archive: Path, sha256: str) -> None:
    """Check the archive of an earlier attempt."""
    try:
        with archive.open("rb") as stream:
            found = hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise CircumspectError(f"{archive}: can not be read ({reason_of(error)})") from error
    if found != sha256.lower():
        raise CircumspectError(
            f"{archive}: is there already, but does not have the checksum {sha256}; remove it to "
            "fetch it again"
        )


def _download(url: str, archive: Path, sha256: str | None, downloader: ResumedDownload) -> None:
    try:
        import pooch
    except ImportError as error:
        raise MissingExtraError("pooch", "data") from error
    pooch.get_logger().setLevel("ERROR")
    fetches: Any = downloader  # pooch has other names for the same arguments
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
    """Unpack beside the target first, so that the target is complete when it appears."""
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
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".unpacking") as temporary:
            for entry in wanted:
                members.extract(entry, temporary)
            (Path(temporary) / "ModelNet10").replace(target)
