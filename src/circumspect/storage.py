"""Results on disk: written aside, then renamed, so that no reader sees half a file."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from circumspect.errors import OutputError


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a path beside `path` that replaces it when the block ends well.

    Args:
        path: The file to write; its folder is made where missing.

    Yields:
        A temporary path in the same folder with the same suffix.

    Raises:
        OutputError: No permission, disk full, or a folder stands where the file should.
    """
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.is_dir():
            raise OutputError(f"{target}: is a folder; give a file name")
        descriptor, name = tempfile.mkstemp(
            prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent
        )
        os.close(descriptor)
    except OSError as error:
        raise OutputError(_explain(target, error)) from error
    aside = Path(name)
    try:
        yield aside
        aside.chmod(0o666 & ~_umask())
        aside.replace(target)
    except OSError as error:
        raise OutputError(_explain(target, error)) from error
    finally:
        with suppress(OSError):
            aside.unlink(missing_ok=True)


@contextmanager
def atomic_open(path: str | os.PathLike[str], mode: str = "w") -> Iterator[IO[Any]]:
    """Open a file for writing that appears under its name only when complete.

    Raises:
        OutputError: The file can not be written.
    """
    encoding = None if "b" in mode else "utf-8"
    with atomic_path(path) as aside, aside.open(mode, encoding=encoding) as stream:
        yield stream


def write_json(path: str | os.PathLike[str], document: Any) -> None:
    """Write `document` as indented JSON.

    Raises:
        OutputError: The file can not be written.
    """
    with atomic_open(path) as stream:
        json.dump(document, stream, indent=2, ensure_ascii=False)
        stream.write("\n")


def _explain(path: Path, error: OSError) -> str:
    reason = (error.strerror or str(error)).lower()
    return f"{path}: can not be written ({reason}); free space or choose another place"


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
