"""The file of a classifier with taught classes: the classes and the base classifier."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from circumspect.classification.onnx_inspection import MAX_FILE_BYTES
from circumspect.classification.shipped import SHIPPED, shipped_path
from circumspect.classification.taught_classes import TaughtClass
from circumspect.errors import InputError, WeightsError, reason_of
from circumspect.storage import write_json

SUFFIX = ".json"
FORMAT = 1
MAX_BYTES = 64 << 20
MAX_CLASSES = 100


@dataclass(frozen=True, eq=False)
class TaughtFile:
    """The content of the file.

    Attributes:
        base: A shipped classifier's name, or the name of an ONNX file beside this file.
        sha256: Of the base's ONNX file when it was taught.
        classes: In the order in which they were taught.
        examples: Name of a class to the SHA-256 hashes of its examples.
    """

    base: str
    sha256: str
    classes: tuple[TaughtClass, ...]
    examples: Mapping[str, tuple[str, ...]]

    def base_path(self, file: Path) -> Path:
        """The file of the base's ONNX network.

        Args:
            file: The taught classifier's file.
        """
        return shipped_path(self.base) if self.base in SHIPPED else file.parent / self.base

    def require_base(self, file: Path) -> Path:
        """Check that the base's ONNX file is the one that was taught.

        Raises:
            WeightsError: It is missing or has changed.
        """
        path = self.base_path(file)
        try:
            if not path.is_file() or path.stat().st_size > MAX_FILE_BYTES:
                raise OSError("it is no ONNX file")
            found = hashlib.sha256(path.read_bytes()).hexdigest()
        except OSError as error:
            raise WeightsError(
                f"{file}: the classifier that was taught, {path}, can not be read "
                f"({reason_of(error)})"
            ) from error
        if found != self.sha256:
            raise WeightsError(
                f"{file}: {path} is another network than the one that was taught; teach it again: "
                "circumspect teach --replace"
            )
        return path

    def save(self, path: Path) -> None:
        """Write as JSON.

        Raises:
            OutputError: The file cannot be written.
        """
        write_json(
            path,
            {
                "circumspect_taught": FORMAT,
                "base": self.base,
                "sha256": self.sha256,
                "classes": [one.to_dict() for one in self.classes],
                "examples": {name: list(hashes) for name, hashes in self.examples.items()},
            },
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> TaughtFile:
        """Read what `save` wrote.

        Raises:
            WeightsError: Missing, broken, of a later version, or another JSON file.
        """
        file = Path(path)
        try:
            return _checked(_document(file))
        except InputError as error:
            raise WeightsError(f"{file}: {error}") from error


def _document(file: Path) -> Mapping[str, Any]:
    try:
        if not file.is_file():
            raise InputError("no such file")
        if file.stat().st_size > MAX_BYTES:
            raise InputError(f"larger than {MAX_BYTES >> 20} MiB; no taught classifier is")
        document = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"can not be read ({reason_of(error)})") from error
    except (ValueError, RecursionError) as error:
        raise InputError("not a taught classifier: no JSON; teach it again") from error
    if not isinstance(document, dict) or "circumspect_taught" not in document:
        raise InputError("not a taught classifier; circumspect teach writes them")
    return document


def _checked(document: Mapping[str, Any]) -> TaughtFile:
    number = document["circumspect_taught"]
    if number != FORMAT:
        raise InputError(f"format {number!r:.20}; this version reads {FORMAT}; update circumspect")
    base, sha256 = document.get("base"), document.get("sha256")
    classes, examples = document.get("classes"), document.get("examples")
    # A name, not a path: nothing outside of the folder is read.
    named = isinstance(base, str) and base and Path(base).name == base and "\0" not in base
    if not named or not isinstance(base, str) or not isinstance(sha256, str):
        raise InputError("broken: it does not name the classifier that was taught")
    if not isinstance(classes, list) or not 0 < len(classes) <= MAX_CLASSES:
        raise InputError("broken: it has no classes, or too many")
    found = tuple(map(TaughtClass.from_dict, classes))
    if len({one.name for one in found}) < len(found):
        raise InputError("broken: its classes are not distinct")
    if not isinstance(examples, dict) or not all(isinstance(h, list) for h in examples.values()):
        raise InputError("broken: it does not name its examples")
    hashes = {str(name): tuple(map(str, entries)) for name, entries in examples.items()}
    return TaughtFile(base, sha256, found, hashes)
