"""A file that is written in several steps."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from circumspect.errors import CircumspectError
from circumspect.storage import atomic_path


@contextmanager
def draft_of(path: Path) -> Iterator[Path]:
    """Yield a file that replaces `path` if all steps succeed; see `atomic_path`.

    Error messages about the draft name `path` instead, which users know.

    Raises:
        OutputError: The file can not be written.
    """
    with atomic_path(path) as draft:
        try:
            yield draft
        except CircumspectError as error:
            if str(draft) not in str(error):
                raise
            raise type(error)(str(error).replace(str(draft), str(path))) from error
