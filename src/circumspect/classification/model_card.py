"""The measured figures of a classifier, in a file beside its weights."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from circumspect.errors import InputError, reason_of
from circumspect.storage import write_json

SUFFIX = ".card.json"
FORMAT = 1
SHARE = "share"
"""The unit of a fraction of 1; it is shown in percent."""
NETWORK_TIME = "network time"
"""The measure that `circumspect models` shows in a column of its own."""
MAX_BYTES = 1 << 20


@dataclass(frozen=True)
class CardFigure:
    """A measured figure of a classifier.

    Attributes:
        measure: What was measured, such as "accuracy, mean over 64 yaws".
        value: The figure.
        unit: "share" of a fraction of 1, else a unit such as "ms"; "" of a plain number.
        data: Its data, such as "ModelNet10 test, 908 objects".
        command: The command that measures it again.
        source: The file of the repository that holds the result; "" for none.
        headline: Whether `circumspect models` shows it in its table.

    Raises:
        InputError: A value of another kind, or one that is not finite.
    """

    measure: str
    value: float
    unit: str
    data: str
    command: str
    source: str = ""
    headline: bool = False

    def __post_init__(self) -> None:
        for name in ("measure", "unit", "data", "command", "source"):
            text = getattr(self, name)
            if not isinstance(text, str) or not (text.isprintable() and len(text) <= 300):
                raise InputError(f"'{name}' of a figure must be a line of text, not {text!r:.40}")
        number = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        if not number or not math.isfinite(self.value):
            raise InputError(f"'value' of a figure must be a finite number, not {self.value!r:.40}")
        if not isinstance(self.headline, bool):
            raise InputError(f"'headline' must be true or false, not {self.headline!r:.40}")

    @property
    def text(self) -> str:
        """The value with its unit."""
        if self.unit == SHARE:
            return f"{100 * self.value:.1f} %"
        return f"{self.value:.3g} {self.unit}".rstrip()


@dataclass(frozen=True)
class ModelCard:
    """The measured figures of a classifier.

    Attributes:
        sha256: Of the ONNX file that was measured.
        figures: The figures, in the order in which they are shown.
    """

    sha256: str
    figures: tuple[CardFigure, ...]

    @property
    def network_time(self) -> CardFigure | None:
        """How long the network takes for one object; None if not measured."""
        return next((one for one in self.figures if one.measure == NETWORK_TIME), None)

    @property
    def headlines(self) -> tuple[CardFigure, ...]:
        """The figures of the table of all classifiers."""
        return tuple(figure for figure in self.figures if figure.headline)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as JSON.

        Raises:
            OutputError: The file cannot be written.
        """
        figures = [asdict(figure) for figure in self.figures]
        write_json(Path(path), {"format": FORMAT, "sha256": self.sha256, "figures": figures})

    @staticmethod
    def load(path: str | os.PathLike[str]) -> ModelCard:
        """Read what `save` wrote.

        Raises:
            InputError: The file is missing, broken or of a later version.
        """
        file = Path(path)
        try:
            return _checked(_document(file))
        except InputError as error:
            raise InputError(f"{file}: {error}") from error


def card_path(weights: Path) -> Path:
    """The file of a classifier's card, beside the classifier's file."""
    return weights.with_name(f"{weights.stem}{SUFFIX}")


def _document(file: Path) -> Any:
    try:
        if not file.is_file():
            raise InputError("no such file")
        if file.stat().st_size > MAX_BYTES:
            raise InputError(f"larger than {MAX_BYTES >> 20} MiB; no model card is")
        return json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"can not be read ({reason_of(error)})") from error
    except (ValueError, RecursionError) as error:
        raise InputError("not a model card in JSON; write it again") from error


def _checked(document: Any) -> ModelCard:
    if not isinstance(document, Mapping) or document.get("format") != FORMAT:
        raise InputError(f"not a model card of format {FORMAT}; write it again")
    sha256, figures = document.get("sha256"), document.get("figures")
    if not isinstance(sha256, str) or not isinstance(figures, list):
        raise InputError("a model card needs a text 'sha256' and a list 'figures'")
    return ModelCard(sha256, tuple(map(_figure, figures)))


def _figure(entry: Any) -> CardFigure:
    known = [field.name for field in fields(CardFigure)]
    if not isinstance(entry, Mapping):
        raise InputError(f"a figure must be an object, not {entry!r:.40}")
    if unknown := sorted(set(entry) - set(known)):
        raise InputError(f"a figure has no {unknown[0]!r:.40}; known: {', '.join(known)}")
    if missing := [name for name in known[:5] if name not in entry]:
        raise InputError(f"a figure needs '{missing[0]}'")
    return CardFigure(**entry)
