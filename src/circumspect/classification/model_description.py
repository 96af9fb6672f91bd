"""The metadata of a classifier's ONNX file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.input_spec import InputSpec
from circumspect.classification.input_spec_dict import input_spec_from_dict, with_current_names
from circumspect.classification.open_set import OpenSetRule
from circumspect.errors import InputError, WeightsError

METADATA_KEY = "circumspect"
"""Key of the description in the metadata of an ONNX file; the value is JSON."""
FORMAT = 3
"""Version of the description. Version 2 added visibility, metric size, open set and confidence;
version 3 renamed "staggered" to "dithered"."""
OBJECTS = "objects"
"""Key of the names of the training objects in a network's record of its training."""


class LaterFormatError(WeightsError):
    """An intact file of a later version."""


@dataclass(frozen=True)
class ModelDescription:
    """Classes, input, calibration and confidence of a classifier's network.

    Attributes:
        outputs: The classes of the columns of the logits.
        other: The column of other things, which is never a label; None without one.
        input_spec: The input of the network.
        temperature: Divides the logits.
        unknown_beyond: Distance from the nearest training object beyond which an object is out of
            distribution; infinite where the file has none.
        open_set: The model that separates objects of other kinds; None where the file has none.
        rule: The bounds that make an answer confident.
    """

    outputs: tuple[str, ...]
    other: int | None
    input_spec: InputSpec
    temperature: float
    unknown_beyond: float
    open_set: OpenSetRule | None
    rule: ConfidenceRule

    @classmethod
    def from_dict(cls, description: Mapping[str, Any]) -> ModelDescription:
        """Read what `export` and `calibrate` wrote.

        Raises:
            LaterFormatError: The file is of a later version.
            WeightsError: Its classes are broken.
            InputError: A value is out of range.
            KeyError: An entry is missing.
        """
        description = current_description(description)
        outputs = checked_classes(description["classes"])
        require_training_record(description.get("training") or {})
        beyond, open_set = description.get("unknown_beyond"), description.get("open_set")
        return cls(
            outputs,
            _other_column(description, outputs),
            input_spec_from_dict(description["grid"]),
            checked_temperature(description.get("temperature", 1.0)),
            np.inf if beyond is None else checked_distance(beyond),
            None if open_set is None else OpenSetRule.from_dict(open_set),
            ConfidenceRule.from_dict(description.get("confidence")),
        )

    @property
    def classes(self) -> tuple[str, ...]:
        """The labels, in the order of the logits."""
        return tuple(name for column, name in enumerate(self.outputs) if column != self.other)

    @property
    def has_open_set(self) -> bool:
        """Whether it can report an object as out of distribution."""
        return self.open_set is not None or bool(np.isfinite(self.unknown_beyond))


def current_description(description: Any) -> dict[str, Any]:
    """Convert the description of an earlier version.

    Args:
        description: JSON value from the metadata of an ONNX file.

    Returns:
        The description in version `FORMAT`.

    Raises:
        LaterFormatError: The file is of a later version.
        WeightsError: The description is no object, or its version is no number.
        InputError: The input specification holds an entry under two names.
    """
    if not isinstance(description, dict):
        raise WeightsError("its description is no object")
    number = description.get("format", 1)
    if isinstance(number, bool) or not isinstance(number, int) or number < 1:
        raise WeightsError(f"its input format is {number!r:.20}, not 1 to {FORMAT}")
    if number > FORMAT:
        raise LaterFormatError(
            f"input format {number}; this version reads up to {FORMAT}; update circumspect"
        )
    if number == FORMAT or not isinstance(grid := description.get("grid"), dict):
        return description
    return {**description, "format": FORMAT, "grid": with_current_names(grid)}


def _other_column(description: Mapping[str, Any], classes: tuple[str, ...]) -> int | None:
    """The column of the class of other things."""
    other = description.get("other")
    if other is None:
        return None
    if other not in classes or len(classes) < 2:
        raise WeightsError(f"its class of other things, {other!r:.40}, is none of its classes")
    return classes.index(other)


def require_training_record(training: Any) -> None:
    """Check the training record of a file.

    Raises:
        WeightsError: It, its settings or its figures are no object, or the training objects are not
            names.
    """
    if not isinstance(training, dict):
        raise WeightsError("its record of the training is no object")
    for key in ("settings", "reached"):
        if not isinstance(training.get(key, {}), dict):
            raise WeightsError(f"'{key}' in its record of the training is no object")
    names = training.get(OBJECTS) or []
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise WeightsError("the training objects in its record of the training are not names")


def checked_classes(classes: Any) -> tuple[str, ...]:
    """Check the class names of a file.

    Raises:
        WeightsError: Not a list of distinct names.
    """
    names = isinstance(classes, list) and all(isinstance(name, str) for name in classes)
    if not names or not all(0 < len(name) <= 200 and name.isprintable() for name in classes):
        raise WeightsError("its classes are not names")
    if not classes or len(set(classes)) != len(classes):
        raise WeightsError(f"its classes are not distinct: {', '.join(classes)[:200]}")
    return tuple(classes)


def checked_temperature(value: Any) -> float:
    """Check a divisor of logits.

    Raises:
        InputError: Not a positive finite number.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < np.inf:
        raise InputError(f"the temperature must be a positive number, not {value!r}")
    return float(value)


def checked_distance(value: Any) -> float:
    """Check a distance from the nearest training object beyond which an object is unknown.

    Raises:
        InputError: Not within 0 … 2.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 2:
        raise InputError(f"the distance of the unknown must lie in 0 … 2, not {value!r}")
    return float(value)
