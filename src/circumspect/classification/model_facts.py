"""Everything known of a classifier: the content of its file, and its measured figures."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from circumspect.classification.model_card import ModelCard, card_path
from circumspect.classification.model_description import OBJECTS
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.shipped import (
    DEFAULT,
    SHIPPED,
    ShippedClassifier,
    model_path,
    shipped_name,
)

OPEN_SET = ("other", "open_set", "unknown_beyond", "confidence")
"""Entries of a file's description that say when an object is unknown and an answer confident."""


@dataclass(frozen=True, eq=False)
class ModelFacts:
    """A classifier with its file and its figures.

    Attributes:
        name: The requested name: that of a shipped classifier, or a file.
        shipped: Its entry among the shipped ones; None for a file of one's own.
        classifier: Loaded.
        size: Of the file [bytes].
        sha256: Of the file.
        card: The figures beside the file; None where there are none of this very file.
        stale: There are figures, but of another file.
    """

    name: str
    shipped: ShippedClassifier | None
    classifier: OnnxClassifier
    size: int
    sha256: str
    card: ModelCard | None
    stale: bool

    @staticmethod
    def load(model: str | os.PathLike[str]) -> ModelFacts:
        """Load a classifier and look beside it.

        Args:
            model: As `Classifier.load` takes it.

        Raises:
            WeightsError: See `Classifier.load`.
            InputError: The card beside it is broken.
        """
        classifier, path = OnnxClassifier.load(model), model_path(model)
        content, beside = path.read_bytes(), card_path(path)
        sha256 = hashlib.sha256(content).hexdigest()
        card = ModelCard.load(beside) if beside.is_file() else None
        stale = card is not None and card.sha256 != sha256
        return ModelFacts(
            os.fspath(model), SHIPPED.get(shipped_name(model) or ""), classifier, len(content),
            sha256, None if stale else card, stale,
        )  # fmt: skip

    @property
    def training_data(self) -> str | None:
        """Training data and taught classes in words; None where unknown."""
        if self.shipped is not None:
            return self.shipped.training_data
        taught = self.classifier.taught
        words = ", ".join(f"{one.name} ({len(one.features)} examples)" for one in taught)
        return f"taught: {words}" if words else None

    @property
    def training_objects(self) -> int | None:
        """How many objects it was trained on; None where the file does not say."""
        names = self.classifier.training.get(OBJECTS)
        return len(names) if isinstance(names, list) else None

    @property
    def training_settings(self) -> Mapping[str, Any]:
        """How it was trained; empty where the file does not say."""
        settings = self.classifier.training.get("settings")
        return settings if isinstance(settings, dict) else {}

    @property
    def open_set(self) -> Mapping[str, Any]:
        """When the file calls an object unknown, as the file says it."""
        described = self.classifier.description
        return {key: described[key] for key in OPEN_SET if described.get(key) is not None}

    def to_dict(self) -> dict[str, Any]:
        """The facts in JSON types, as `circumspect models --json` prints them."""
        shipped = self.shipped
        return {
            "name": self.name,
            "shipped": shipped is not None,
            "taught": dict(self.classifier.description.get("taught", {})),
            "default": shipped is not None and shipped.name == DEFAULT,
            "summary": None if shipped is None else shipped.summary,
            "training_data": self.training_data,
            "classes": list(self.classifier.classes),
            "input": self.classifier.input_spec.to_dict(),
            "network": self.classifier.description.get("name"),
            "temperature": self.classifier.temperature,
            **self.open_set,
            "training_objects": self.training_objects,
            "training_settings": dict(self.training_settings),
            "bytes": self.size,
            "sha256": self.sha256,
            "figures": [asdict(figure) for figure in self.card.figures] if self.card else [],
        }


def setting_text(value: Any) -> str:
    """A value of a file's description, for a reader: yes, 0.1, 32 x 32 x 32.

    Args:
        value: Of JSON types.
    """
    if isinstance(value, dict):
        return ", ".join(f"{key} {setting_text(entry)}" for key, entry in value.items())
    if isinstance(value, list | tuple):
        sizes = all(isinstance(entry, int) for entry in value)
        return (" x " if sizes else ", ").join(map(setting_text, value))
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)
