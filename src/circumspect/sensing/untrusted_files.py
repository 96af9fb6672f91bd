"""Access to untrusted files (regular files, images, YAML) with limits."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from circumspect.errors import InputError, MissingExtraError, reason_of

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_LEVELS = 20
"""Maximum nesting depth."""


@contextmanager
def opened_picture(
    source: Path | bytes, formats: Sequence[str], max_side: int, name: str | None = None
) -> Iterator[Image]:
    """Open an image for the duration of the context.

    Args:
        source: A file, or the content of one.
        formats: Pillow's names of the allowed formats. Pillow passes some others to external
            programs.
        max_side: Maximum image side [px]; a small file can contain a huge image.
        name: Name for error messages; by default the path of the file.

    Raises:
        InputError: The image is missing, broken (even if that is noticed later), too large, or of
            another format.
    """
    from PIL import Image, UnidentifiedImageError

    name = name or str(source)
    try:
        with _held(source) as held, Image.open(held, formats=tuple(formats)) as picture:
            if max(picture.size) > max_side:
                raise InputError(f"{name}: has {picture.size[0]} x {picture.size[1]} pixels; "
                                 f"{max_side} along a side are read")  # fmt: skip
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
    """A file from which no more is read than it contains.

    Pillow reads as many bytes as a PNG chunk announces, and Python allocates memory for them.
    """

    def read(self, size: int | None = -1, /) -> bytes:
        if size is not None and size > io.DEFAULT_BUFFER_SIZE:
            size = min(size, max(os.fstat(self.fileno()).st_size - self.tell(), 0))
        return super().read(size)


def require_regular(file: Path) -> None:
    """Refuse devices, pipes and sockets; the caller reports folders and missing files.

    Raises:
        OSError: It exists, but is not a regular file.
    """
    if file.exists() and not file.is_file() and not file.is_dir():
        raise OSError("not a regular file")


def read_yaml(path: Path, max_bytes: int, what: str, extra: str, loader: Any = None) -> Any:
    """Read a YAML document.

    Args:
        path: The file.
        max_bytes: Maximum size of the file.
        what: Description of the expected file for error messages, such as "a parameter file".
        extra: Extra of this package that installs PyYAML.
        loader: A `yaml.SafeLoader`, a subclass of it, or a function that returns one; None for the
            default.

    Raises:
        InputError: It cannot be read, is too large, is not YAML, has aliases or is deeply nested.
        MissingExtraError: PyYAML is not installed.
    """
    try:
        import yaml
    except ImportError as error:
        raise MissingExtraError("PyYAML", extra) from error
    try:
        require_regular(path)
        with path.open("rb") as stream:
            data = stream.read(max_bytes + 1)
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    if len(data) > max_bytes:
        raise InputError(f"{path}: has more than {max_bytes} bytes; is it {what}?")
    if data.startswith(b"%YAML:"):
        # OpenCV's own directive is none of YAML's.
        data = data.partition(b"\n")[2]
    try:
        _guard(yaml, data, path)
        return yaml.load(data, yaml.SafeLoader if loader is None else loader())
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        where = "" if mark is None else f" at line {mark.line + 1}"
        raise InputError(f"{path}: is not YAML{where}") from error


def _guard(yaml: Any, data: bytes, path: Path) -> None:
    """Refuse what is small to write and large to read."""
    depth = 0
    for event in yaml.parse(data):
        # A few lines of aliases of aliases can stand for more than any memory holds.
        if isinstance(event, yaml.AliasEvent):
            raise InputError(f"{path}: has aliases (*name), which are not read")
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_LEVELS:
            raise InputError(f"{path}: is nested deeper than {MAX_LEVELS} levels")
