"""Sweet Home 3D's furniture catalogues: zips of properties and models.

Catalogues are untrusted: sizes are bounded before anything is unpacked, everything is unpacked in
memory, and names from the properties are looked up in the archive alone.
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
from circumspect.geometry.file_faults import blamed_on

SUFFIX = ".sh3f"
PROPERTIES = (
    "PluginFurnitureCatalog.properties",
    "com/eteks/sweethome3d/io/DefaultFurnitureCatalog.properties",
)
"""Of a catalogue of its own, and of the default one within the program's jar."""
LARGEST_PROPERTIES = 16 << 20
LARGEST_MODEL = 64 << 20
HARMLESS_MODEL = 4 << 20
MOST_UNPACKED = 64
"""Text packs tenfold: a larger model may not be so many times as large as it was packed."""
LONGEST_TEXT = 500
"""Of names and licences [characters]."""

UNSOUND = (
    zipfile.BadZipFile, zlib.error, struct.error, EOFError, RuntimeError, ValueError,
    OverflowError,
)  # fmt: skip
"""What broken and encrypted archives raise …"""
DAMAGED = (zipfile.BadZipFile, zlib.error, EOFError)
"""… and those of them that no longer hold what was packed."""

_KEY = re.compile(r"(name|category|model|width|depth|height|modelRotation|creator|license)#(\d+)")


class SkipCode(StrEnum):
    """Why a piece is left out."""

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
    """A piece that is left out; the rest of its catalogue can be used."""

    def __init__(self, code: SkipCode, reason: str) -> None:
        super().__init__(reason)
        self.code = code


@dataclass(frozen=True)
class Piece:
    """What the properties say of a piece; nothing is checked yet.

    Attributes:
        number: Of its keys.
        properties: Key without number to value.
    """

    number: int
    properties: dict[str, str]

    def text(self, key: str) -> str:
        """A value without anything that breaks a line, cut where it is very long; "" if missing."""
        return printable(self.properties.get(key, "")[:LONGEST_TEXT])

    @property
    def title(self) -> str:
        """What the catalogue calls it.

        Raises:
            PieceError: It has no name, so that nobody knows what it is.
        """
        title = self.text("name")
        if not title:
            raise PieceError(SkipCode.NO_NAME, "has no name")
        return title

    @property
    def model(self) -> str:
        """Path of the model in the archive.

        Raises:
            PieceError: There is none.
        """
        path = self.properties.get("model", "").strip()
        if not path:
            raise PieceError(SkipCode.NO_MODEL, "names no model")
        return path.lstrip("/")


@dataclass(frozen=True)
class Catalogue:
    """What the properties of a catalogue say.

    Attributes:
        path: The file.
        licence: Of all its pieces that name none of their own.
        pieces: In the order of their numbers.
    """

    path: Path
    licence: str
    pieces: tuple[Piece, ...]

    @property
    def name(self) -> str:
        """The file's name without suffix."""
        return printable(self.path.stem)


class Models:
    """The models of an open catalogue."""

    def __init__(self, path: Path, archive: zipfile.ZipFile) -> None:
        self._path, self._archive = path, archive

    def read(self, model: str) -> bytes:
        """An OBJ file from the archive, or from a zip within it.

        Args:
            model: `folder/chair.obj`, `folder/chair.zip` or `folder/chair.zip!/chair.obj`.

        Raises:
            PieceError: It is missing, broken or too large, or of another format.
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
    """Read what a catalogue lists.

    Args:
        path: A .sh3f file, or the jar of the program.

    Raises:
        InputError: The file is missing, no readable zip or no catalogue; the message names it.
    """
    with blamed_on(path) as file, _opened(file) as archive:
        properties = parse_properties(_properties(archive))
    licence = printable(properties.get("license", "")[:LONGEST_TEXT])
    return Catalogue(path, licence, _pieces(properties))


@contextmanager
def open_models(path: Path) -> Iterator[Models]:
    """Open a catalogue to read its models.

    Args:
        path: A .sh3f file, or the jar of the program.

    Raises:
        InputError: The file is missing or no readable zip; the message names it.
    """
    with blamed_on(path) as file:
        archive = _opened(file)
    with archive:
        yield Models(path, archive)


def catalogue_files(path: Path) -> list[Path]:
    """The catalogues that a path stands for, in order.

    Args:
        path: A file, which stands for itself, or a folder: all .sh3f files below it, and jars
            that hold the default catalogue.

    Raises:
        InputError: There are none, or a jar is no readable zip.
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
    with blamed_on(jar) as file, _opened(file) as archive:
        return _found(archive, *PROPERTIES) is not None


def _opened(file: Path) -> zipfile.ZipFile:
    try:
        return zipfile.ZipFile(file)
    except UNSOUND as error:
        raise InputError(f"is no readable zip ({error}); get the file again") from error


def _found(archive: zipfile.ZipFile, *names: str) -> zipfile.ZipInfo | None:
    """The member of the first of some names that is there."""
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
    if item.file_size > LARGEST_PROPERTIES:
        raise InputError(
            f"{item.filename} would unpack to {item.file_size >> 20} MiB; "
            f"{LARGEST_PROPERTIES >> 20} are read"
        )
    try:
        return _unpacked(archive, item)
    except UNSOUND as error:
        raise InputError(f"{item.filename} is broken ({error}); get the file again") from error


def _unpacked(archive: zipfile.ZipFile, item: zipfile.ZipInfo) -> bytes:
    """No more bytes than the archive announces; other ways to pack take memory without bounds."""
    if item.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise RuntimeError("packed in a way that Java does not know")
    return archive.read(item)


def _pieces(properties: dict[str, str]) -> tuple[Piece, ...]:
    """Numbers may be missing, and keys of each number too."""
    by_number: dict[int, dict[str, str]] = {}
    for key, value in properties.items():
        # Longer numbers would be no keys of a catalogue, and Python refuses to read some.
        if (match := _KEY.fullmatch(key)) and len(match[2]) < 10:
            by_number.setdefault(int(match[2]), {})[match[1]] = value
    return tuple(Piece(number, by_number[number]) for number in sorted(by_number))


def _require_obj(model: str) -> None:
    suffix = posixpath.splitext(model)[1].lower()
    if suffix != ".obj":
        raise PieceError(SkipCode.UNREAD_FORMAT, f"its format {suffix or '(none)'} is not read")


def _nested(data: bytes, outer: str, inner: str) -> bytes:
    """An OBJ file from a zip in memory: the one named, or the one that seems meant."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(data))
    except UNSOUND as error:
        raise PieceError(SkipCode.BROKEN_MODEL, f"its model is a broken zip ({error})") from error
    with archive:
        name = inner or _obj_in(archive, outer)
        _require_obj(name)
        try:
            return _member(archive, name)
        except DAMAGED as error:
            # What the catalogue holds is intact: its author packed a broken one.
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
    """A member's bytes; a name from the properties may be written as in a URL.

    Raises:
        PieceError: It is missing, too large, encrypted, or packed in an unknown way.
        zipfile.BadZipFile, zlib.error, EOFError: It is damaged.
    """
    item = _found(archive, name, unquote(name))
    if item is None:
        raise PieceError(SkipCode.MISSING_FILE, "its model is not in the catalogue")
    limit = max(HARMLESS_MODEL, MOST_UNPACKED * item.compress_size)
    if item.file_size > min(limit, LARGEST_MODEL):
        raise PieceError(
            SkipCode.TOO_LARGE,
            f"its model would unpack from {item.compress_size >> 10} KiB to "
            f"{item.file_size >> 20} MiB",
        )
    try:
        return _unpacked(archive, item)
    except DAMAGED:
        raise
    except UNSOUND as error:
        raise _broken(error) from error


def _broken(error: Exception) -> PieceError:
    return PieceError(SkipCode.BROKEN_MODEL, f"its model is broken ({error})")
