"""A classifier in ONNX Runtime."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.classification.classifier import Classifier
from circumspect.classification.cloud_checks import is_one_object, require_plausible_size
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.grid_spec import GridSpec
from circumspect.classification.input_spec import InputSpec
from circumspect.classification.model_description import ModelDescription, current_description
from circumspect.classification.network_outputs import NetworkOutputs
from circumspect.classification.open_set import OpenSetRule
from circumspect.classification.opened_network import open_own, open_shipped
from circumspect.classification.prediction import Prediction
from circumspect.classification.shipped import SHIPPED, model_path, shipped_name
from circumspect.classification.taught_classes import TaughtClass, TaughtClasses
from circumspect.classification.taught_file import SUFFIX, TaughtFile
from circumspect.errors import InputError, WeightsError
from circumspect.geometry import PointCloud
from circumspect.geometry.given_shapes import as_cloud
from circumspect.grid import OccupancyGrid


class OnnxClassifier(Classifier):
    """Runs a network that `circumspect export` wrote; see `Classifier`."""

    def __init__(
        self, session: Any, description: dict[str, Any], taught: TaughtClasses | None = None
    ) -> None:
        self.description = current_description(description)
        """Description in the file: name, classes, grid, temperature, training and, with the
        training objects, unknown_beyond."""
        self._described = ModelDescription.from_dict(self.description)
        self._network = NetworkOutputs(session, self._described, taught)
        self._loaded_with: tuple[str, int, str | None] | None = None

    @staticmethod
    def load(
        model: str | os.PathLike[str] | None = None,
        threads: int = 0,
        input_spec: str | os.PathLike[str] | None = None,
    ) -> OnnxClassifier:
        """See `Classifier.load`."""
        name = shipped_name(model)
        if name is not None:
            if input_spec is not None:
                raise InputError(
                    f"{input_spec}: the classifier '{name}' needs no input specification"
                )
            shipped = OnnxClassifier(*open_shipped(name, threads))
            shipped._loaded_with = (name, threads, None)
            return shipped
        file = model_path(model)
        if file.suffix.lower() == SUFFIX:
            if input_spec is not None:
                raise InputError(f"{input_spec}: {file} needs no input specification")
            own = _taught(file, threads)
        else:
            own = OnnxClassifier(*open_own(model or "", threads, input_spec))
        # Absolute: never a shipped name, and the same file in every process.
        spec = None if input_spec is None else str(Path(input_spec).absolute())
        own._loaded_with = (str(file.absolute()), threads, spec)
        return own

    def with_taught(self, classes: Sequence[TaughtClass]) -> OnnxClassifier:
        """The same classifier with taught classes in place of earlier ones.

        Args:
            classes: In the order of the outputs, after those of the network.

        Raises:
            WeightsError: The network gives no features.
            InputError: It names one of the classes already, or the features are of another width.
        """
        if not self.gives_features:
            raise WeightsError("these weights give no features to teach; export them again")
        session, earlier = self._network.session, {one.name for one in self.taught}
        names = [name for name in self._described.outputs if name not in earlier]
        if not classes:
            return OnnxClassifier(session, {**self.description, "classes": names})
        for one in classes:
            if one.name in names:
                raise InputError(f"the classifier names {one.name} already")
            one.require_width(self._network.feature_width)
        named = [*names, *(one.name for one in classes)]
        taught = {one.name: len(one.features) for one in classes}
        description = {**self.description, "classes": named, "taught": taught}
        return OnnxClassifier(session, description, TaughtClasses(tuple(classes), self.temperature))

    @property
    def taught(self) -> tuple[TaughtClass, ...]:
        """The taught classes."""
        taught = self._network.taught
        return () if taught is None else tuple(taught.classes)

    def __reduce__(self) -> tuple[Callable[..., OnnxClassifier], tuple[str, int, str | None]]:
        """A copy, in this or in another process, is loaded from the same file again.

        Raises:
            TypeError: It came from no file.
        """
        if self._loaded_with is None:
            raise TypeError(
                "a classifier that came from no file can not be copied or pickled; make it with "
                "Classifier.load(model)"
            )
        return OnnxClassifier.load, self._loaded_with

    def __repr__(self) -> str:
        input_spec = self.input_spec
        shape = "x".join(map(str, input_spec.input_shape)).removeprefix(
            "1x"
        )  # Of its only channel.
        views = f"{input_spec.azimuth_views} view{'' if input_spec.azimuth_views == 1 else 's'}"
        if isinstance(input_spec, GridSpec) and input_spec.dithered:
            views = f"{input_spec.azimuth_views} dithered views"
        return f"OnnxClassifier({len(self.classes)} classes, {input_spec.kind} {shape}, {views})"

    @property
    def classes(self) -> tuple[str, ...]:
        """See `Classifier.classes`."""
        return self._described.classes

    @property
    def input_spec(self) -> InputSpec:
        """See `Classifier.input_spec`."""
        return self._described.input_spec

    @property
    def temperature(self) -> float:
        """Divisor of the logits."""
        return self._described.temperature

    @property
    def training(self) -> Mapping[str, Any]:
        """Training record; empty if the file has none."""
        training = self.description.get("training")
        return training if isinstance(training, dict) else {}

    def classify(
        self,
        cloud: PointCloud | ArrayLike,
        *,
        metric: bool = False,
        coverage: float | None = None,
    ) -> Prediction:
        """See `Classifier.classify`."""
        start, cloud = time.perf_counter(), as_cloud(cloud)
        if metric:
            require_plausible_size(cloud)
        inputs = self.input_spec.inputs(cloud)
        bounds = self.input_spec.bounds(cloud) if metric and self.input_spec.metric else None
        context = self.input_spec.context(inputs[0], bounds)
        times = {"grid": 1e3 * (time.perf_counter() - start)}
        prediction = self._prediction(inputs, context, times, coverage)
        if self._described.has_open_set and not is_one_object(cloud.points_xyz):
            return replace(prediction, in_distribution=False)
        return prediction

    def classify_grid(
        self, *views: OccupancyGrid, metric: bool = False, coverage: float | None = None
    ) -> Prediction:
        """See `Classifier.classify_grid`."""
        if not views:
            raise InputError("there is no grid to name; give one at least")
        for grid in views:
            if not isinstance(grid, OccupancyGrid):
                raise InputError(
                    f"a view is an OccupancyGrid, not a {type(grid).__name__}; of several: "
                    "classify_grid(*views), of bounds: classify_grid(bounds.hits(points))"
                )
            self.input_spec.accepts(grid)
        input_spec = self.input_spec
        inputs = np.stack([input_spec.input_of(grid) for grid in views])
        context = input_spec.context(inputs, views[0].grid if metric else None)
        return self._prediction(inputs[None], context, {}, coverage)

    def _prediction(
        self,
        inputs: NDArray[Any],
        context: NDArray[np.float32] | None,
        milliseconds: Mapping[str, float],
        coverage: float | None,
    ) -> Prediction:
        """The answer for one object."""
        if coverage is not None and not 0.0 <= coverage <= 1.0:
            raise InputError(f"the coverage must lie in 0 … 1, not {coverage!r}")
        start, contexts = time.perf_counter(), None if context is None else context[None]
        logits, distances = self._network.logits_and_distances(inputs, contexts)
        distance = None if distances is None else float(distances[0])
        probabilities, other = self._network.softmax(logits)
        times = {**milliseconds, "classify": 1e3 * (time.perf_counter() - start)}
        belongs = None
        if self._described.open_set is not None:
            belongs = float(self._described.open_set.probability(other[0], distance))
            known = belongs >= self._described.open_set.threshold
        else:
            known = distance is None or distance <= self._described.unknown_beyond
        return Prediction.from_probabilities(
            self.classes, probabilities[0], times, in_distribution=known, distance=distance,
            coverage=coverage, rule=self._described.rule, in_distribution_probability=belongs,
        )  # fmt: skip

    def classify_inputs(
        self,
        inputs: NDArray[Any],
        context: NDArray[np.float32] | None = None,
        coverage: float | None = None,
    ) -> Prediction:
        """Classify one object from its inputs.

        Args:
            inputs: (1, views, *input_shape) as `input_spec.inputs` makes them.
            context: (6,) as `input_spec.context` makes it; None means an unknown scale.
            coverage: See `classify`.

        Raises:
            InputError: A coverage that is no share.
        """
        return self._prediction(inputs, context, {}, coverage)

    def probabilities(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Class probabilities of many objects.

        Args:
            inputs: (n, views, *input_shape) as `input_spec.inputs` makes them; logits are averaged
                over views.
            contexts: (n, 6) as `input_spec.context` makes them; None means an unknown scale.

        Returns:
            (n, c) that sum to 1 along each row.
        """
        return self._network.softmax(self._network.logits(inputs, contexts))[0]

    def scores(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Logits of many objects, divided by the temperature: their softmax is the probabilities.

        Args:
            inputs: (n, views, *input_shape) as `input_spec.inputs` makes them.
            contexts: (n, 6) as `input_spec.context` makes them; None means an unknown scale.

        Returns:
            (n, c), averaged over views.
        """
        return self._network.scores(self._network.logits(inputs, contexts))

    def open_set_signs(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
        """The two signs that `OpenSetRule` combines.

        Args:
            inputs: (n, views, *input_shape).
            contexts: (n, 6); None means an unknown scale.

        Returns:
            (n,) the probability of "other", and (n,) the distance to the nearest training object,
            or None where the file does not hold them.
        """
        logits, distances = self._network.logits_and_distances(inputs, contexts)
        return self._network.softmax(logits)[1], distances

    @property
    def rule(self) -> ConfidenceRule:
        """The bounds that make an answer confident."""
        return self._described.rule

    @property
    def open_set(self) -> OpenSetRule | None:
        """Model for objects of other kinds; None if the file has none."""
        return self._described.open_set

    @property
    def other(self) -> str | None:
        """Name of the network's class of other things, which is never a label."""
        column = self._described.other
        return None if column is None else self._described.outputs[column]

    def features(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Features of the last layer for many objects; similar objects have similar features.

        Args:
            inputs: (n, views, *input_shape) as `input_spec.inputs` makes them.
            contexts: (n, 6) as `input_spec.context` makes them; None means an unknown scale.

        Returns:
            (n, f), averaged over views.

        Raises:
            WeightsError: The file does not give its features.
        """
        return self._network.features(inputs, contexts)

    def distances(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Distances of many objects from the nearest training objects, see `NearExample`.

        Args:
            inputs: (n, views, *input_shape) as `input_spec.inputs` makes them.
            contexts: (n, 6) as `input_spec.context` makes them; None means an unknown scale.

        Returns:
            (n,), averaged over views.

        Raises:
            WeightsError: The file does not hold its training objects.
        """
        return self._network.distances(inputs, contexts)

    @property
    def gives_features(self) -> bool:
        """Whether the file was exported with its features."""
        return self._network.gives_features

    @property
    def gives_distances(self) -> bool:
        """Whether the file was exported with its training objects."""
        return self._network.gives_distances


def _taught(file: Path, threads: int) -> OnnxClassifier:
    """A classifier with taught classes, together with its base."""
    taught = TaughtFile.load(file)
    path = taught.require_base(file)
    base = OnnxClassifier.load(taught.base if taught.base in SHIPPED else path, threads)
    try:
        return base.with_taught(taught.classes)
    except InputError as error:
        raise WeightsError(f"{file}: {error}; teach it again") from error
