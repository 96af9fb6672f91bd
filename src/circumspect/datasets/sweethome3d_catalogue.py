"""Sweet Home 3D's furniture catalogues: zips of properties and models.

Catalogues are untrusted: sizes are checked before unpacking, unpacking is in memory, and names from
the properties are only looked up in the archive.
"""

from __future__ import annotations

import io
import posixpath
import re
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from urllib.parse import unquote

from circumspect.datasets.java_properties import parse_properties
from circumspect.errors import InputError, printable, reason_of
from circumspect.geometry.formats.file_errors import reading_file

SUFFIX = ".sh3f"
PROPERTIES = (
    "PluginFurnitureCatalog.properties",
    "com/eteks/sweethome3d/io/DefaultFurnitureCatalog.properties",
)
"""Names of the properties in a catalogue, and in the default one within the program's jar."""
MAX_PROPERTIES_BYTES = 16 << 20
MAX_MODEL_BYTES = 64 << 20
UNCHECKED_MODEL_BYTES = 4 << 20
MAX_UNPACKING_RATIO = 64
"""Maximum ratio of unpacked to packed size of larger models; for text it is about 10."""
MAX_TEXT_LENGTH = 500
"""Maximum length of names and licences [characters]."""

MALFORMED = (
    zipfile.BadZipFile, zlib.error, struct.error, EOFError, RuntimeError, ValueError,
    OverflowError,
)  # fmt: skip
"""Exceptions for broken and encrypted archives."""
DAMAGED = (zipfile.BadZipFile, zlib.error, EOFError)
"""Exceptions for archives whose content is damaged."""

_KEY = re.compile(r"(name|category|model|width|depth|height|modelRotation|creator|license)#(\d+)")


class SkipCode(StrEnum):
    """Reason why a piece is left out."""

    NO_NAME = "no_name"
    NO_MODEL = "no_model"
    MISSING_FILE = "missing_file"
    UNREAD_FORMAT = "unread_format"
    BAD_SIZE = "bad_size"
    BAD_ROTATION = "bad_rotation"
    TOO_LARGE = "too_large"
    BROKEN_MODEL = "broken_model"
    DUPLICATE = "duplicate"


class PieceError(InputError):
    """A piece that is left out; the rest of its catalogue is usable."""

    def __init__(self, code: SkipCode, reason: str) -> None:
        super().__init__(reason)
        self.code = code


@dataclass(frozen=True)
class Piece:
    """The properties of a piece, unchecked.

    Attributes:
        number: Number in the keys of the properties.
        properties: Values by key without number.
    """

    number: int
    properties: dict[str, str]

    def text(self, key: str) -> str:
        """A printable value of limited length; "" if missing."""
        return printable(self.properties.get(key, "")[:MAX_TEXT_LENGTH])

    @property
    def title(self) -> str:
        """Name in the catalogue.

        Raises:
            PieceError: The piece has no name.
        """
        title = self.text("name")
        if not title:
            raise PieceError(SkipCode.NO_NAME, "has no name")
        return title

    @property
    def model(self) -> str:
        """Path of the model in the archive.

        Raises:
            PieceError: The piece has no model.
        """
        path = self.properties.get("model", "").strip()
        if not path:
            raise PieceError(SkipCode.NO_MODEL, "names no model")
        return path.lstrip("/")


@dataclass(frozen=True)
class Catalogue:
    """The properties of a catalogue.

    Attributes:
        path: The file.
        licence: Licence of all pieces without their own.
        pieces: Pieces in the order of their numbers.
    """

    path: Path
    licence: str
    pieces: tuple[Piece, ...]

    @property
    def name(self) -> str:
        """The file's name without suffix."""
        return printable(self.path.stem)


class ModelArchive:
    """The models of an open catalogue."""

    def __init__(self, path: Path, archive: zipfile.ZipFile) -> None:
        self._path, self._archive = path, archive

    def read(self, model: str) -> bytes:
        """Read an OBJ file from the archive, or from a zip within it.

        Args:
            model: `folder/chair.obj`, `folder/chair.zip` or `folder/chair.zip!/chair.obj`.

        Raises:
            PieceError: The file is missing, broken, too large, or has another format.
            InputError: The catalogue is damaged, or the disk fails.
        """
        outer, _, inner = model.partition("!")
        try:
            if outer.lower().endswith(".zip"):
                return _nested(_member(self._archive, outer), outer, inner.lstrip("/"))
            _require_obj(model)
            return _member(self._archive, model)
        except DAMAGED as error:
            raise InputError(f"{self._path}: is damaged ({error}); get the file again") from error
        except OSError as error:
            raise InputError(f"{self._path}: can not be read ({reason_of(error)})") from error


def read_catalogue(path: Path) -> Catalogue:
    """Read the list of a catalogue.

    Args:
        path: A .sh3f file, or the jar of the program.

    Raises:
        InputError: The file is missing, not a readable zip or not a catalogue; the message names
            it.
    """
    with reading_file(path) as file, _opened(file) as archive:
        properties = parse_properties(_properties(archive))
    licence = printable(properties.get("license", "")[:MAX_TEXT_LENGTH])
    return Catalogue(path, licence, _pieces(properties))


@contextmanager
def open_models(path: Path) -> Iterator[ModelArchive]:
    """Open a catalogue to read its models.

    Args:
        path: A .sh3f file, or the jar of the program.

    Raises:
        InputError: The file is missing or not a readable zip; the message names it.
    """
    with reading_file(path) as file:
        archive = _opened(file)
    with archive:
        yield ModelArchive(path, archive)


def catalogue_files(path: Path) -> list[Path]:
    """The catalogues of a path, in order.

    Args:
        path: A file, or a folder; of a folder, all .sh3f files below it, and jars that contain the
            default catalogue.

    Raises:
        InputError: There are none, or a jar is not a readable zip.
    """
    if not path.is_dir():
        return [path]
    files = sorted(file for file in path.rglob("*") if file.is_file())
    found = [
        file
        for file in files
        if file.suffix.lower() == SUFFIX
        or (file.suffix.lower() == ".jar" and _holds_catalogue(file))
    ]
    if not found:
        raise InputError(
            f"{path}: no {SUFFIX} file in it or below it; unpack Debian's packages "
            "sweethome3d-furniture and sweethome3d there, for example"
        )
    return found


def _holds_catalogue(jar: Path) -> bool:
    with reading_file(jar) as file, _opened(file) as archive:
        return _found(archive, *PROPERTIES) is not None


def _opened(file: Path) -> zipfile.ZipFile:
    try:
        return zipfile.ZipFile(file)
    except MALFORMED as error:
        raise InputError(f"is no readable zip ({error}); get the file again") from error


def _found(archive: zipfile.ZipFile, *names: str) -> zipfile.ZipInfo | None:
    """The first existing member of some names."""
    for name in names:
        try:
            return archive.getinfo(name)
        except KeyError:
            continue
    return None


def _properties(archive: zipfile.ZipFile) -> bytes:
    item = _found(archive, *PROPERTIES)
    if item is None:
        raise InputError(f"holds no {PROPERTIES[0]}; it is no furniture catalogue")
    if item.file_size > MAX_PROPERTIES_BYTES:
        raise InputError(
            f"{item.filename} would unpack to {item.file_size >> 20} MiB; "
            f"{MAX_PROPERTIES_BYTES >> 20} are read"
        )
    try:
        return _unpacked(archive, item)
    except MALFORMED as error:
        raise InputError(f"{item.filename} is broken ({error}); get the file again") from error


def _unpacked(archive: zipfile.ZipFile, item: zipfile.ZipInfo) -> bytes:
    """Unpack a member in bounded memory, to no more bytes than announced."""
    if item.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise RuntimeError("packed in a way that Java does not know")
    return archive.read(item)


def _pieces(properties: dict[str, str]) -> tuple[Piece, ...]:
    """Pieces by number; numbers, and keys of each number, may be missing."""
    by_number: dict[int, dict[str, str]] = {}
    for key, value in properties.items():
        # Keys of a catalogue have no longer numbers, and Python refuses to parse very long ones.
        if (match := _KEY.fullmatch(key)) and len(match[2]) < 10:
            by_number.setdefault(int(match[2]), {})[match[1]] = value
    return tuple(Piece(number, by_number[number]) for number in sorted(by_number))


def _require_obj(model: str) -> None:
    suffix = posixpath.splitext(model)[1].lower()
    if suffix != ".obj":
        raise PieceError(SkipCode.UNREAD_FORMAT, f"its format {suffix or '(none)'} is not read")


def _nested(data: bytes, outer: str, inner: str) -> bytes:
    """An OBJ file from a zip in memory: the named one, or the most likely one."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(data))
    except MALFORMED as error:
        raise PieceError(SkipCode.BROKEN_MODEL, f"its model is a broken zip ({error})") from error
    with archive:
        name = inner or _obj_in(archive, outer)
        _require_obj(name)
        try:
            return _member(archive, name)
        except DAMAGED as error:
            # The catalogue is intact; its author packed a broken zip.
            raise _broken(error) from error


def _obj_in(archive: zipfile.ZipFile, outer: str) -> str:
    """The OBJ file named after the zip, or the first."""
    names = sorted(name for name in archive.namelist() if name.lower().endswith(".obj"))
    if not names:
        raise PieceError(SkipCode.UNREAD_FORMAT, "its zip holds no OBJ file")
    stem = posixpath.splitext(posixpath.basename(outer))[0]
    alike = (name for name in names if posixpath.basename(name)[:-4] == stem)
    return next(alike, names[0])


def _member(archive: zipfile.ZipFile, name: str) -> bytes:
    """A member's bytes; a name from the properties may be URL-encoded.

    Raises:
        PieceError: It is missing, too large, encrypted, or packed in an unknown way.
        zipfile.BadZipFile, zlib.error, EOFError: It is damaged.
    """
    item = _found(archive, name, unquote(name))
    if item is None:
        raise PieceError(SkipCode.MISSING_FILE, "its model is not in the catalogue")
    limit = max(UNCHECKED_MODEL_BYTES, MAX_UNPACKING_RATIO * item.compress_size)
    if item.file_size > min(limit, MAX_MODEL_BYTES):
        raise PieceError(
            SkipCode.TOO_LARGE,
            f"its model would unpack from {item.compress_size >> 10} KiB to "
            f"{item.file_size >> 20} MiB",
        )
    try:
        return _unpacked(archive, item)
    except DAMAGED:
        raise
    except MALFORMED as error:
        raise _broken(error) from error


def _broken(error: Exception) -> PieceError:
    return PieceError(SkipCode.BROKEN_MODEL, f"its model is broken ({error})")
