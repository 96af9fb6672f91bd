"""Whatever goes wrong with a file that is read, in one line that names it."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

import numpy as np

from circumspect.errors import InputError, printable, reason_of

LARGEST_FILE = 4 << 30
"""Of one object or trajectory [bytes]; more would fill the memory of a robot."""
# In a folder of so many files the search for similar names stops.
_LOOK_AT = 5000
_LONGEST = 600


@contextmanager
def blamed_on(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Turn whatever goes wrong with a file into one line that names it."""
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
        if file.stat().st_size > LARGEST_FILE:
            raise InputError(f"is larger than {LARGEST_FILE >> 30} GiB; thin it out first")
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
    """Files of nearly the same name, or the remark that the folder is missing as well."""
    if not path.parent.is_dir():
        return f"; nor does the folder {path.parent}"
    names = [entry.name for entry in islice(path.parent.iterdir(), _LOOK_AT)]
    near = difflib.get_close_matches(path.name, names)
    return f"; near it: {', '.join(near)}" if near else "; check the path"


def _one_line(message: str) -> str:
    """The message without anything that breaks a line or garbles a terminal, and not endless."""
    plain = printable(message[:_LONGEST])
    return plain if len(message) <= _LONGEST else plain + " …"
