"""A file that several steps make."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from circumspect.errors import CircumspectError
from circumspect.storage import atomic_path


@contextmanager
def draft_of(path: Path) -> Iterator[Path]:
    """Yield a file beside `path` that takes its place when all steps ended well; see `atomic_path`.

    What a step finds wrong with the draft is told of `path`: nobody knows the draft's name.

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
