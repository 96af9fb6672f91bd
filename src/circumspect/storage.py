"""Results on disk: written aside, then renamed, so that no reader sees half a file.

After a loss of power a file is the old one or the new one as a whole.
"""

from __future__ import annotations

import errno
import json
import math
import os
import re
import secrets
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from circumspect.errors import OutputError, reason_of

_PARTIAL = "-partial-"
_ABANDONED = re.compile(rf"\..{{0,32}}{_PARTIAL}[0-9a-f]{{12}}(\..*)?")


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a path beside `path` that replaces it when the block ends well.

    Whatever ends the block early, an interruption too, leaves the old file as it was.

    Args:
        path: The file to write; its folder is made where missing. A link is followed.

    Yields:
        An empty temporary file in the same folder with the same suffix.

    Raises:
        OutputError: No permission, disk full, or something else stands where the file should.
    """
    target = Path(path)
    aside = None
    try:
        try:
            target = _resolved(target)
            aside = _create_aside(target)
            yield aside
            _sync(aside)
            aside.replace(target)
            # Without it a loss of power may bring the earlier file back.
            _sync(target.parent)
        finally:
            if aside is not None:
                with suppress(OSError):
                    aside.unlink(missing_ok=True)
    except OSError as error:
        if not _is_about(error, target, aside):
            raise
        raise OutputError(_explain(Path(path), error)) from error


def remove_abandoned(folder: Path) -> None:
    """Remove temporary files of runs that were killed from a folder that nobody else writes to."""
    for file in folder.glob(f".*{_PARTIAL}*"):
        if _ABANDONED.fullmatch(file.name) and file.is_file():
            with suppress(OSError):
                file.unlink()


def _sync(path: Path) -> None:
    """Wait until the disk has a file, or a folder's names.

    Raises:
        OSError: It has not; not all file systems can sync folders.
    """
    place = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(place)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EBADF):
            raise
    finally:
        os.close(place)


def require_writable(folder: str | os.PathLike[str]) -> None:
    """Find out before long work whether its results can be written.

    Args:
        folder: Made where missing; nothing is left in it.

    Raises:
        OutputError: It can not be written.
    """
    try:
        _create_aside(_resolved(Path(folder)) / secrets.token_hex(6)).unlink()
    except OSError as error:
        raise OutputError(_explain(Path(folder), error)) from error


def make_new_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder that was not there, and that nobody else gets who asks at the same moment.

    Args:
        path: What to call it; its parents are made where missing. A name that is taken gets a
            number: run-2, run-3, …

    Returns:
        The folder.

    Raises:
        OutputError: No permission, disk full, or its parent is no folder.
    """
    wanted = folder = Path(path)
    count = 1
    try:
        wanted.parent.mkdir(parents=True, exist_ok=True)
        while True:
            try:
                folder.mkdir()
                return folder
            except FileExistsError:
                count += 1
                folder = wanted.with_name(f"{wanted.name}-{count}")
    except OSError as error:
        raise OutputError(_explain(folder, error)) from error


def require_no_strangers(
    folder: str | os.PathLike[str],
    names: Iterable[str],
    signs: Iterable[str],
    foreign: Iterable[str] = (),
) -> None:
    """Find out before a run whether it would replace what only has the name of a result.

    Args:
        folder: Of the run; may be missing.
        names: Of files and folders that the run replaces.
        signs: Of those that every earlier run of its kind left.
        foreign: Of those that runs of another kind leave.

    Raises:
        OutputError: Some of the names are there, and the folder is of no earlier run of its kind.
    """

    def there(wanted: Iterable[str]) -> list[str]:
        return [name for name in wanted if os.path.lexists(Path(folder) / name)]

    signs, found = list(signs), there(names)
    if found and (there(signs) != signs or there(foreign)):
        raise OutputError(
            f"{Path(folder) / found[0]}: is of no such run and would be replaced; "
            "take another folder"
        )


@contextmanager
def atomic_open(path: str | os.PathLike[str], mode: str = "w") -> Iterator[IO[Any]]:
    """Open a file for writing that appears under its name only when complete.

    Args:
        path: The file to write; its folder is made where missing.
        mode: "w" for text (UTF-8), "wb" for bytes.

    Raises:
        OutputError: The file can not be written.
    """
    encoding = None if "b" in mode else "utf-8"
    with atomic_path(path) as aside, aside.open(mode, encoding=encoding) as stream:
        yield stream


def write_json(path: str | os.PathLike[str], document: Any) -> None:
    """Write `document` as indented JSON.

    NumPy's numbers and arrays are written as plain ones, numbers that are not finite (which JSON
    does not know) as null.

    Raises:
        OutputError: The file can not be written.
    """
    with atomic_open(path) as stream:
        json.dump(_plain(document), stream, indent=2, ensure_ascii=False, allow_nan=False)
        stream.write("\n")


def append_line(path: str | os.PathLike[str], line: str, durable: bool = False) -> None:
    """Add a line to a file of lines, whole or not at all.

    A last line that an earlier interruption cut is dropped first.

    Args:
        path: The file; made where missing.
        line: Without its end.
        durable: Wait until the disk has it.

    Raises:
        OutputError: It can not be written; the file is as it was.
    """
    try:
        with Path(path).open("a+b", buffering=0) as stream:
            end = _drop_cut_line(stream)
            try:
                _write_all(stream, line.encode() + b"\n")
                if durable:
                    os.fsync(stream.fileno())
            except OSError:
                stream.truncate(end)
                raise
    except OSError as error:
        raise OutputError(_explain(Path(path), error)) from error


def _drop_cut_line(stream: Any) -> int:
    """Where the last whole line ends; what is behind it is cut off."""
    end = stream.seek(0, os.SEEK_END)
    if end:
        stream.seek(end - 1)
        if stream.read(1) != b"\n":
            stream.seek(0)
            end = stream.readall().rfind(b"\n") + 1
            stream.truncate(end)
    return end


def _write_all(stream: Any, data: bytes) -> None:
    """A raw file takes what fits, and only the next write says why no more does."""
    view = memoryview(data)
    while view:
        view = view[stream.write(view) :]


def _resolved(path: Path) -> Path:
    try:
        return path.resolve()
    except RuntimeError as error:  # Links in a circle; an OSError from Python 3.13 on.
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP)) from error


def _create_aside(target: Path) -> Path:
    if target.is_dir():
        raise OutputError(f"{target}: is a folder; give a file name")
    if target.exists() and not target.is_file():
        raise OutputError(f"{target}: is not a regular file; give another name")
    target.parent.mkdir(parents=True, exist_ok=True)
    mark = f"{_PARTIAL}{secrets.token_hex(6)}"
    aside = target.with_name(f".{target.stem[:32]}{mark}{target.suffix[:16]}")
    # Exclusive, and with the permissions that any new file of this user gets.
    os.close(os.open(aside, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    return aside


def _is_about(error: OSError, target: Path, aside: Path | None) -> bool:
    """Whether an error concerns the file written, not another one used in the block."""
    if isinstance(error, ConnectionError):  # A closed pipe, for example, is no full disk.
        return False
    if aside is None or not isinstance(error.filename, str | bytes):
        return True
    return Path(os.fsdecode(error.filename)) in (aside, target)


def _explain(path: Path, error: OSError) -> str:
    return f"{path}: can not be written ({reason_of(error)}); free space or choose another place"


def _plain(document: Any) -> Any:
    """The document in terms that JSON knows."""
    if isinstance(document, Mapping):
        return {str(key): _plain(value) for key, value in document.items()}
    if isinstance(document, list | tuple):
        return [_plain(value) for value in document]
    if isinstance(document, float):
        return float(document) if math.isfinite(document) else None
    if isinstance(document, os.PathLike):
        return os.fspath(document)
    if hasattr(document, "tolist"):  # NumPy's scalars and arrays, without importing NumPy.
        return _plain(document.tolist())
    return document
