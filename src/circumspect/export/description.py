"""What an exported file says of itself, and so how its network is asked."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import onnx

from circumspect.classification import Classifier, InputRecipe
from circumspect.classification.model_description import METADATA_KEY, checked_temperature
from circumspect.storage import atomic_path


def describe(network: onnx.ModelProto, description: Mapping[str, Any]) -> None:
    """Let a network say this of itself, and nothing else.

    Args:
        network: Changed in place.
        description: As JSON types; see `OnnxClassifier.description`.
    """
    del network.metadata_props[:]
    entry = network.metadata_props.add()
    entry.key, entry.value = METADATA_KEY, json.dumps(description)


def write_asked_otherwise(
    path: Path, recipe: InputRecipe, temperature: float | None = None
) -> None:
    """Change how an exported network is asked; its weights stay.

    Args:
        path: A classifier.
        recipe: What it is shown, of the same shape.
        temperature: Divides the logits; None keeps what the file says.

    Raises:
        InputError: The temperature is not positive.
        WeightsError: No classifier.
        OutputError: The file can not be written.
    """
    classifier = Classifier.load(path)
    description = {
        **classifier.description,
        "grid": recipe.to_dict(),
        "temperature": checked_temperature(
            classifier.temperature if temperature is None else temperature
        ),
    }
    network = onnx.load_from_string(path.read_bytes())
    describe(network, description)
    with atomic_path(path) as aside:
        aside.write_bytes(network.SerializeToString())


def write_calibrated(path: Path, out: Path, calibration: Mapping[str, Any]) -> None:
    """Write a classifier with another temperature, open-set model and rule of confidence.

    Args:
        path: A classifier.
        out: The file to write; it may be `path` itself.
        calibration: See `Calibration.to_dict`.

    Raises:
        WeightsError: No classifier.
        OutputError: The file can not be written.
    """
    classifier = Classifier.load(path)
    network = onnx.load_from_string(path.read_bytes())
    describe(network, {**classifier.description, **calibration})
    with atomic_path(out) as aside:
        aside.write_bytes(network.SerializeToString())
