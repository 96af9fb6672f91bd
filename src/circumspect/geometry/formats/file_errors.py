"""Errors while a file is read, as one line that names the file."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

import numpy as np

from circumspect.errors import InputError, printable, reason_of

MAX_FILE_BYTES = 4 << 30
"""Largest file of one object or trajectory [bytes]; more would fill the memory of a robot."""
# The search for similar names stops after this many files.
_LOOK_AT = 5000
_MAX_MESSAGE_LENGTH = 600


@contextmanager
def reading_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Convert errors while a file is read to one line that names the file."""
    file = Path(path)
    try:
        if file.is_symlink() and not file.exists():
            raise InputError(f"is a link to {file.readlink()}, which does not exist")
        if not file.exists():
            raise InputError(f"does not exist{_suggestion(file)}")
        if file.is_dir():
            raise InputError("is a folder; name a file in it")
        if not file.is_file():
            raise InputError("is not a regular file; copy its contents to one")
        if file.stat().st_size > MAX_FILE_BYTES:
            raise InputError(f"is larger than {MAX_FILE_BYTES >> 30} GiB; thin it out first")
        with np.errstate(all="ignore"):
            yield file
    except InputError as error:
        raise type(error)(_one_line(f"{file}: {error}")) from error
    except OSError as error:
        raise InputError(_one_line(f"{file}: can not be read ({reason_of(error)})")) from error
    except MemoryError as error:
        raise InputError(
            _one_line(f"{file}: does not fit into memory; thin it out first")
        ) from error


def _suggestion(path: Path) -> str:
    """A hint at files of nearly the same name, or that the folder is missing as well."""
    if not path.parent.is_dir():
        return f", and the folder {path.parent} does not either"
    names = [entry.name for entry in islice(path.parent.iterdir(), _LOOK_AT)]
    near = difflib.get_close_matches(path.name, names)
    return f"; near it: {', '.join(near)}" if near else "; check the path"


def _one_line(message: str) -> str:
    """The message as one printable line of limited length."""
    plain = printable(message[:_MAX_MESSAGE_LENGTH])
    return plain if len(message) <= _MAX_MESSAGE_LENGTH else plain + " …"
