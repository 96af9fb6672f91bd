"""The description in an exported file, which sets its inputs and calibration."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import onnx

from circumspect.classification import Classifier, InputSpec
from circumspect.classification.model_description import METADATA_KEY, OBJECTS, checked_temperature
from circumspect.datasets import ObjectSet
from circumspect.datasets.fitted_objects import fitted_objects
from circumspect.storage import atomic_path


def describe(network: onnx.ModelProto, description: Mapping[str, Any]) -> None:
    """Replace the metadata of a network by a description.

    Args:
        network: Changed in place.
        description: As JSON types; see `OnnxClassifier.description`.
    """
    del network.metadata_props[:]
    entry = network.metadata_props.add()
    entry.key, entry.value = METADATA_KEY, json.dumps(description)


def write_with_input_spec(
    path: Path, input_spec: InputSpec, temperature: float | None = None
) -> None:
    """Change input specification and temperature of an exported network; its weights stay.

    Args:
        path: A classifier.
        input_spec: The new one, of the same shape.
        temperature: Divides the logits; None keeps what the file says.

    Raises:
        InputError: The temperature is not positive.
        WeightsError: No classifier.
        OutputError: The file cannot be written.
    """
    classifier = Classifier.load(path)
    description = {
        **classifier.description,
        "grid": input_spec.to_dict(),
        "temperature": checked_temperature(
            classifier.temperature if temperature is None else temperature
        ),
    }
    network = onnx.load_from_string(path.read_bytes())
    describe(network, description)
    with atomic_path(path) as temporary:
        temporary.write_bytes(network.SerializeToString())


def write_calibrated(path: Path, out: Path, calibration: Mapping[str, Any]) -> None:
    """Write a classifier with another temperature, open-set model and rule of confidence.

    Args:
        path: A classifier.
        out: The file to write; it may be `path` itself.
        calibration: See `ClassifierCalibration.to_dict`.

    Raises:
        WeightsError: No classifier.
        OutputError: The file cannot be written.
    """
    classifier = Classifier.load(path)
    network = onnx.load_from_string(path.read_bytes())
    describe(network, {**classifier.description, **calibration})
    with atomic_path(out) as temporary:
        temporary.write_bytes(network.SerializeToString())


def write_fitted_names(path: Path, objects: ObjectSet) -> bool:
    """Complete a file that was exported by an older version; its network stays as it is.

    Args:
        path: A classifier.
        objects: The training split that it was trained on.

    Returns:
        Whether the file was changed: not if it holds the names already, or was trained on another
        set.

    Raises:
        WeightsError: No classifier.
        OutputError: The file cannot be written.
    """
    classifier = Classifier.load(path)
    training = classifier.training
    if OBJECTS in training or training.get("data") != objects.digest:
        return False
    names = objects.names[fitted_objects(training, objects)].tolist()
    network = onnx.load_from_string(path.read_bytes())
    describe(network, {**classifier.description, "training": {**training, OBJECTS: names}})
    with atomic_path(path) as temporary:
        temporary.write_bytes(network.SerializeToString())
    return True
