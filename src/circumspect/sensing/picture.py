"""Pictures that anybody may have made, opened within limits."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING

from circumspect.errors import InputError
from circumspect.sensing.regular_file import require_regular

if TYPE_CHECKING:
    from PIL.Image import Image


@contextmanager
def opened_picture(
    source: Path | bytes, formats: Sequence[str], largest: int, name: str | None = None
) -> Iterator[Image]:
    """A picture, open for as long as the context lasts.

    Args:
        source: A file, or what a file holds.
        formats: By Pillow's names. It knows more, and hands some of them to other programs.
        largest: Most pixels along a side; a small file can hold a huge picture of one colour.
        name: What complaints call it; without it the file's path.

    Raises:
        InputError: It is missing, broken, too large, or of another format; also where its pixels
            turn out to be broken within the context.
    """
    from PIL import Image, UnidentifiedImageError

    name = name or str(source)
    try:
        with _held(source) as held, Image.open(held, formats=tuple(formats)) as picture:
            if max(picture.size) > largest:
                raise InputError(f"{name}: has {picture.size[0]} x {picture.size[1]} pixels; "
                                 f"{largest} along a side are read")  # fmt: skip
            yield picture
    except UnidentifiedImageError as error:
        known = ", ".join(formats)
        raise InputError(f"{name}: can not be read (no picture of the formats {known})") from error
    # Pillow reports broken files by any of these.
    except (
        OSError,
        ValueError,
        SyntaxError,
        MemoryError,
        Image.DecompressionBombError,
        Image.DecompressionBombWarning,
    ) as error:
        raise InputError(f"{name}: can not be read ({error})") from error


def _held(source: Path | bytes) -> IO[bytes]:
    if isinstance(source, bytes):
        return io.BytesIO(source)
    require_regular(source)
    return _WithinFile(io.FileIO(source))


class _WithinFile(io.BufferedReader):
    """A file of which no more is asked for than it holds.

    Pillow reads as many bytes as a chunk of a PNG announces, and Python makes room for them.
    """

    def read(self, size: int | None = -1, /) -> bytes:
        if size is not None and size > io.DEFAULT_BUFFER_SIZE:
            size = min(size, max(os.fstat(self.fileno()).st_size - self.tell(), 0))
        return super().read(size)
