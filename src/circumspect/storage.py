"""Results on disk: written to a temporary file, then renamed, so that no reader sees half a file.

After a loss of power a file is either the old or the new one.
"""

from __future__ import annotations

import errno
import json
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from circumspect.errors import OutputError, reason_of

_PARTIAL = "-partial-"
_ABANDONED = re.compile(rf"\..{{0,32}}{_PARTIAL}[0-9a-f]{{12}}(\..*)?")


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path that replaces `path` when the block ends without an error.

    Otherwise, and after an interruption, the old file stays.

    Args:
        path: The file to write; its folder is made if missing. A link is followed.

    Yields:
        An empty temporary file in the same folder with the same suffix.

    Raises:
        OutputError: No permission, disk full, or the path is no file.
    """
    target = Path(path)
    temporary = None
    try:
        try:
            target = _resolved(target)
            temporary = _create_temporary(target)
            yield temporary
            _sync(temporary)
            temporary.replace(target)
            # Otherwise a loss of power could restore the earlier file.
            _sync(target.parent)
        finally:
            if temporary is not None:
                with suppress(OSError):
                    temporary.unlink(missing_ok=True)
    except OSError as error:
        if not _is_about(error, target, temporary):
            raise
        raise OutputError(_explain(Path(path), error)) from error


def remove_abandoned(folder: Path) -> None:
    """Remove temporary files of killed runs from a folder without other writers."""
    for file in folder.glob(f".*{_PARTIAL}*"):
        if _ABANDONED.fullmatch(file.name) and file.is_file():
            with suppress(OSError):
                file.unlink()


def _sync(path: Path) -> None:
    """Wait until a file, or a folder's names, are on the disk.

    Raises:
        OSError: The write failed; not all file systems can sync folders.
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
    """Check before a long run whether its results can be written.

    Args:
        folder: Made if missing; the check leaves no file.

    Raises:
        OutputError: It cannot be written.
    """
    try:
        _create_temporary(_resolved(Path(folder)) / os.urandom(6).hex()).unlink()
    except OSError as error:
        raise OutputError(_explain(Path(folder), error)) from error


def make_new_folder(path: str | os.PathLike[str]) -> Path:
    """Make a new folder that no concurrent caller gets.

    Args:
        path: The preferred path; its parents are made if missing. An existing name gets a number:
            run-2, run-3, …

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


def require_no_foreign_files(
    folder: str | os.PathLike[str],
    names: Iterable[str],
    signs: Iterable[str],
    foreign: Iterable[str] = (),
) -> None:
    """Check before a run whether it would replace files of something else.

    Args:
        folder: Of the run; may be missing.
        names: Files and folders that the run replaces.
        signs: Files and folders that every earlier run of this kind left.
        foreign: Files and folders that runs of another kind leave.

    Raises:
        OutputError: Some of the names exist, and the folder is of no earlier run of this kind.
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
    """Open a file for writing that replaces its target only when complete.

    Args:
        path: The file to write; its folder is made if missing.
        mode: "w" for text (UTF-8), "wb" for bytes.

    Raises:
        OutputError: The file cannot be written.
    """
    encoding = None if "b" in mode else "utf-8"
    with atomic_path(path) as temporary, temporary.open(mode, encoding=encoding) as stream:
        yield stream


def write_json(path: str | os.PathLike[str], document: Any) -> None:
    """Write `document` as indented JSON.

    NumPy's numbers and arrays become plain ones. Numbers that are not finite, which JSON lacks,
    become null.

    Raises:
        OutputError: The file cannot be written.
    """
    with atomic_open(path) as stream:
        json.dump(_plain(document), stream, indent=2, ensure_ascii=False, allow_nan=False)
        stream.write("\n")


def append_line(path: str | os.PathLike[str], line: str, durable: bool = False) -> None:
    """Append a line to a file atomically.

    An incomplete last line from an interruption is removed first.

    Args:
        path: The file; made if missing.
        line: Without its end.
        durable: Wait until it is on the disk.

    Raises:
        OutputError: It cannot be written; the file is unchanged.
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
    """The end of the last complete line; the rest is cut off."""
    end = stream.seek(0, os.SEEK_END)
    if end:
        stream.seek(end - 1)
        if stream.read(1) != b"\n":
            stream.seek(0)
            end = stream.readall().rfind(b"\n") + 1
            stream.truncate(end)
    return end


def _write_all(stream: Any, data: bytes) -> None:
    """Write all bytes: a raw file writes what fits, and only the next write reports the error."""
    view = memoryview(data)
    while view:
        view = view[stream.write(view) :]


def _resolved(path: Path) -> Path:
    try:
        return path.resolve()
    except RuntimeError as error:  # Links in a circle; an OSError from Python 3.13 on.
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP)) from error


def _create_temporary(target: Path) -> Path:
    if target.is_dir():
        raise OutputError(f"{target}: is a folder; give a file name")
    if target.exists() and not target.is_file():
        raise OutputError(f"{target}: is not a regular file; give another name")
    target.parent.mkdir(parents=True, exist_ok=True)
    mark = f"{_PARTIAL}{os.urandom(6).hex()}"
    temporary = target.with_name(f".{target.stem[:32]}{mark}{target.suffix[:16]}")
    # Exclusive, and with the default permissions of new files.
    os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    return temporary


def _is_about(error: OSError, target: Path, temporary: Path | None) -> bool:
    """Whether an error concerns the written file, not another one used in the block."""
    if isinstance(error, ConnectionError):  # A closed pipe, for example, is no full disk.
        return False
    if temporary is None or not isinstance(error.filename, str | bytes):
        return True
    return Path(os.fsdecode(error.filename)) in (temporary, target)


def _explain(path: Path, error: OSError) -> str:
    return f"{path}: can not be written ({reason_of(error)}); free space or choose another place"


def _plain(document: Any) -> Any:
    """The document as JSON types."""
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
