"""A table of the training objects with their features of the network's last layer."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.model_description import OBJECTS
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.shipped import SHIPPED, shipped_path
from circumspect.errors import InputError, WeightsError
from circumspect.geometry import PointCloud
from circumspect.geometry.formats.npy_stream import read_arrays
from circumspect.grid import OccupancyGrid
from circumspect.storage import atomic_open

SUFFIX = ".examples.npz"
MAX_BYTES = 512 << 20
_KINDS = {"features_u8": "u", "low": "f", "step": "f", "labels": "iu", "names": "U",
          "classes": "U", "network": "U"}  # fmt: skip


@dataclass(frozen=True)
class NearExample:
    """A training object near another one.

    Attributes:
        name: Name in the data set, such as chair_0123.
        label: Its class.
        distance: 1 - cos of the angle between the two objects' features: 0 for equal features, 1
            for orthogonal ones.
    """

    name: str
    label: str
    distance: float


@dataclass(frozen=True, eq=False)
class ExampleTable:
    """Names, classes and features of training objects.

    Attributes:
        features: (n, f) float32.
        labels: (n,) int64 indices into `classes`.
        names: (n,) text.
        classes: The class names.
        network: Identifies the network of the features, see `network_of`.

    Raises:
        InputError: The arrays do not belong together.
    """

    features: NDArray[np.float32]
    labels: NDArray[np.int64]
    names: NDArray[np.str_]
    classes: tuple[str, ...]
    network: str

    def __post_init__(self) -> None:
        count = len(self.features)
        if self.features.ndim != 2 or not self.features.size:
            raise InputError(f"features must have shape (n, f), not {self.features.shape}")
        if self.labels.shape != (count,) or self.names.shape != (count,):
            raise InputError(f"{count} examples need as many labels and names")
        if not 0 <= self.labels.min() <= self.labels.max() < len(self.classes):
            raise InputError(f"labels lie outside the {len(self.classes)} classes")
        if not np.isfinite(self.features).all():
            raise InputError("the features hold NaN or infinite values")

    def __len__(self) -> int:
        return len(self.features)

    @cached_property
    def directions(self) -> NDArray[np.float32]:
        """(n, f) the features, of length 1; zeros stay."""
        return _directions(self.features)

    def nearest(self, features: NDArray[np.floating], count: int = 5) -> tuple[NearExample, ...]:
        """The examples whose features have the smallest angle to given features.

        Args:
            features: (f,).
            count: Number of examples.

        Returns:
            The nearest first.

        Raises:
            InputError: Fewer than one wanted, or features of another width.
        """
        if count < 1:
            raise InputError(f"count must be at least 1, not {count}")
        if features.shape != (self.features.shape[1],):
            raise InputError(f"features must be ({self.features.shape[1]},), not {features.shape}")
        distances = 1.0 - self.directions @ _directions(features.astype(np.float32))
        order = np.argsort(distances, kind="stable")[:count]
        return tuple(
            NearExample(
                str(self.names[index]),
                self.classes[self.labels[index]],
                max(0.0, float(distances[index])),
            )
            for index in order
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as npz; each feature is rounded to a 255th of its range.

        Raises:
            OutputError: The file cannot be written.
        """
        low, high = self.features.min(axis=0), self.features.max(axis=0)
        step = np.maximum((high - low) / np.float32(255), np.finfo(np.float32).tiny)
        with atomic_open(path, "wb") as stream:
            np.savez_compressed(
                stream,
                features_u8=np.rint((self.features - low) / step).clip(0, 255).astype(np.uint8),
                low=low,
                step=step,
                labels=self.labels.astype(np.int32),
                names=self.names,
                classes=np.array(self.classes),
                network=np.array([self.network]),
            )

    @staticmethod
    def load(path: str | os.PathLike[str]) -> ExampleTable:
        """Read what `save` wrote.

        Raises:
            InputError: Missing, broken, or no table of examples.
        """
        file = Path(path)
        stored = read_arrays(file, _KINDS, MAX_BYTES)
        try:
            return _unpacked(stored)
        except InputError as error:
            raise InputError(f"{file}: {error}; make it again: export --examples") from error


def nearest_examples(
    classifier: OnnxClassifier,
    shown: PointCloud | OccupancyGrid,
    count: int = 5,
    examples: ExampleTable | None = None,
    *,
    metric: bool = False,
) -> tuple[NearExample, ...]:
    """The training objects most similar to an object in the network's last layer.

    Args:
        classifier: Computes the features.
        shown: An object, as for `classify` or `classify_grid`.
        count: Number of training objects.
        examples: The training objects; None means the table that ships with the classifier.
        metric: The object is in metres; without it its scale counts as unknown.

    Returns:
        The nearest first.

    Raises:
        InputError: A grid or a count that cannot be used.
        GeometryError: A cloud that spans no shape.
        WeightsError: The weights give no features, or the table is of another network.
    """
    table = _table_of(classifier) if examples is None else examples
    if table is None or table.network != network_of(classifier):
        raise WeightsError(
            "the table of training objects is of other weights; make one of these: "
            "circumspect export --examples"
        )
    input_spec = classifier.input_spec
    if isinstance(shown, OccupancyGrid):
        inputs, bounds = input_spec.input_of(shown)[None, None], shown.grid
    else:
        inputs, bounds = input_spec.inputs(shown), input_spec.bounds(shown)
    context = input_spec.context(inputs[0], bounds if metric else None)
    contexts = None if context is None else context[None]
    return table.nearest(classifier.features(inputs, contexts)[0], count)


def network_of(classifier: OnnxClassifier) -> str:
    """A hash that identifies a network: of its name, classes and training.

    Temperature, threshold, arithmetic, the number of grids and the names of the training objects do
    not change it.
    """
    described = {key: classifier.description.get(key) for key in ("name", "classes")}
    training = classifier.training
    described["training"] = {key: training[key] for key in training if key != OBJECTS}
    return hashlib.sha256(json.dumps(described, sort_keys=True).encode()).hexdigest()


def examples_path(weights: Path) -> Path:
    """The file of a classifier's table, beside the classifier's file."""
    return weights.with_name(f"{weights.stem}{SUFFIX}")


@cache
def shipped_examples(name: str) -> ExampleTable:
    """The table of a shipped classifier.

    Raises:
        WeightsError: No classifier has this name.
        InputError: They are missing or broken.
    """
    return ExampleTable.load(examples_path(shipped_path(name)))


def _table_of(classifier: OnnxClassifier) -> ExampleTable | None:
    """The table that ships with a classifier or its original."""
    network = network_of(classifier)
    shipped = (
        shipped_examples(name) for name in SHIPPED if examples_path(shipped_path(name)).is_file()
    )
    return next((table for table in shipped if table.network == network), None)


def _unpacked(stored: Mapping[str, NDArray[Any]]) -> ExampleTable:
    packed, low, step = (stored[name] for name in ("features_u8", "low", "step"))
    if packed.ndim != 2 or low.shape != step.shape or low.shape != packed.shape[1:]:
        raise InputError(f"features {packed.shape} do not fit their ranges {low.shape}")
    if any(stored[name].ndim != 1 for name in ("classes", "network")) or not stored["network"].size:
        raise InputError("classes and network must be lists of text")
    if packed.dtype != np.uint8:
        raise InputError(f"features must be uint8, not {packed.dtype}")
    return ExampleTable(
        (packed * step + low).astype(np.float32),
        stored["labels"].astype(np.int64),
        stored["names"],
        tuple(str(name) for name in stored["classes"]),
        str(stored["network"][0]),
    )


def _directions(features: NDArray[np.float32]) -> NDArray[np.float32]:
    """Vectors of length 1 along the last axis; zeros stay."""
    lengths = np.linalg.norm(features, axis=-1, keepdims=True)
    return features / np.maximum(lengths, np.finfo(np.float32).tiny)
