"""The names of the objects that a network was fitted to, in a file that lacks them."""

from __future__ import annotations

from pathlib import Path

import onnx

from circumspect.classification import Classifier
from circumspect.classification.model_description import OBJECTS
from circumspect.datasets import ObjectSet
from circumspect.datasets.fitted_objects import fitted_objects
from circumspect.export.description import describe
from circumspect.storage import atomic_path


def write_fitted_names(path: Path, objects: ObjectSet) -> bool:
    """Complete a file that was exported by an older version; its network stays as it is.

    Args:
        path: A classifier.
        objects: The training split that it was trained on.

    Returns:
        Whether the file was changed: not where it holds the names, nor where it was trained on
        another set.

    Raises:
        WeightsError: No classifier.
        OutputError: The file can not be written.
    """
    classifier = Classifier.load(path)
    training = classifier.training
    if OBJECTS in training or training.get("data") != objects.digest:
        return False
    names = objects.names[fitted_objects(training, objects)].tolist()
    network = onnx.load_from_string(path.read_bytes())
    describe(network, {**classifier.description, "training": {**training, OBJECTS: names}})
    with atomic_path(path) as aside:
        aside.write_bytes(network.SerializeToString())
    return True
