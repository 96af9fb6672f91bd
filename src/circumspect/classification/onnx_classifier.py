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
from circumspect.classification.context import contexts_of
from circumspect.classification.foreign_session import ForeignSession
from circumspect.classification.grid_spec import GridSpec
from circumspect.classification.input_spec import InputSpec
from circumspect.classification.input_spec_file import InputSpecFile, spec_paths
from circumspect.classification.model_description import (
    LaterFormatError,
    ModelDescription,
    current_description,
)
from circumspect.classification.onnx_session import (
    broken_description,
    check_shapes,
    description_in,
    foreign_network,
    open_session,
    run_in_parts,
    shipped_network,
)
from circumspect.classification.open_set import OpenSetRule
from circumspect.classification.prediction import Prediction
from circumspect.classification.shipped import SHIPPED, model_path, shipped_name
from circumspect.classification.taught_classes import TaughtClass, TaughtClasses
from circumspect.classification.taught_file import SUFFIX, TaughtFile
from circumspect.errors import CircumspectError, InputError, WeightsError
from circumspect.geometry import PointCloud
from circumspect.geometry.given_shapes import as_cloud
from circumspect.grid import OccupancyGrid

FEATURES = "features"
"""Name of the output with the features of the last layer."""
DISTANCE = "distance"
"""Name of the output with the distance from the features of the nearest training object."""


class OnnxClassifier(Classifier):
    """Runs a network that `circumspect export` wrote; see `Classifier`."""

    def __init__(
        self, session: Any, description: dict[str, Any], taught: TaughtClasses | None = None
    ) -> None:
        self._session, self._taught = session, taught
        self.description = current_description(description)
        """Description in the file: name, classes, grid, temperature, training and, with the
        training objects, unknown_beyond."""
        self._described = ModelDescription.from_dict(self.description)
        self._outputs = [output.name for output in session.get_outputs()]
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
            title = f"the classifier '{name}'"
            session = open_session(shipped_network(name), title, threads)
            shipped = _checked(session, description_in(session, title), title)
            shipped._loaded_with = (name, threads, None)
            return shipped
        file = model_path(model)
        if file.suffix.lower() == SUFFIX:
            if input_spec is not None:
                raise InputError(f"{input_spec}: {file} needs no input specification")
            own = _taught(file, threads)
        else:
            own = _own(file, foreign_network(model or ""), threads, input_spec)
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
        earlier = () if self._taught is None else self._taught.classes
        names = [name for name in self._described.outputs if name not in {c.name for c in earlier}]
        if not classes:
            return OnnxClassifier(self._session, {**self.description, "classes": names})
        for one in classes:
            if one.name in names:
                raise InputError(f"the classifier names {one.name} already")
            one.require_width(self._session.get_outputs()[self._outputs.index(FEATURES)].shape[1])
        named = [*names, *(one.name for one in classes)]
        taught = {one.name: len(one.features) for one in classes}
        description = {**self.description, "classes": named, "taught": taught}
        return OnnxClassifier(
            self._session, description, TaughtClasses(tuple(classes), self.temperature)
        )

    @property
    def taught(self) -> tuple[TaughtClass, ...]:
        """The taught classes."""
        return () if self._taught is None else tuple(self._taught.classes)

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
        start, distance = time.perf_counter(), None
        contexts = None if context is None else context[None]
        if self.gives_distances:
            logits, distances = self._means_over_views(inputs, contexts, self._outputs[0], DISTANCE)
            distance = float(_single(distances)[0])
        else:
            (logits,) = self._means_over_views(inputs, contexts, self._outputs[0])
        probabilities, other = self._softmax(logits)
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
        (logits,) = self._means_over_views(inputs, contexts, self._outputs[0])
        return self._softmax(logits)[0]

    def _softmax(
        self, logits: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(n, c) probabilities of the classes, and (n,) that of "other" beside them."""
        scores = self._scores(logits)
        powers = np.exp(scores - scores.max(axis=1, keepdims=True))
        shares = powers / powers.sum(axis=1, keepdims=True)
        other = self._described.other
        if other is None:
            return shares, np.zeros(len(shares))
        named = np.delete(powers, other, axis=1)
        # A row of nothing but "other" also has a nearest class.
        named = np.maximum(named, np.finfo(np.float64).tiny)
        return named / named.sum(axis=1, keepdims=True), shares[:, other]

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
        (logits,) = self._means_over_views(inputs, contexts, self._outputs[0])
        scores, other = self._scores(logits), self._described.other
        return scores if other is None else np.delete(scores, other, axis=1)

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
        outputs = (self._outputs[0], *((DISTANCE,) if self.gives_distances else ()))
        logits, *distances = self._means_over_views(inputs, contexts, *outputs)
        return self._softmax(logits)[1], _single(distances[0]) if distances else None

    def _scores(self, logits: NDArray[np.float64]) -> NDArray[np.float64]:
        if logits.shape[1] != len(self._described.outputs):
            raise WeightsError(f"these weights give {logits.shape[1]} scores an input")
        return logits / self._described.temperature

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
        if not self.gives_features:
            raise WeightsError("these weights give no features; export them again")
        (features,) = self._means_over_views(inputs, contexts, FEATURES)
        return features

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
        if not self.gives_distances:
            raise WeightsError("these weights hold no training objects; use export --examples")
        (distances,) = self._means_over_views(inputs, contexts, DISTANCE)
        return _single(distances)

    @property
    def gives_features(self) -> bool:
        """Whether the file was exported with its features."""
        return FEATURES in self._outputs[1:]

    @property
    def gives_distances(self) -> bool:
        """Whether the file was exported with its training objects."""
        return DISTANCE in self._outputs[1:]

    def _means_over_views(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None, *outputs: str
    ) -> list[NDArray[np.float64]]:
        """The outputs of the network, extended by the taught classes."""
        if self._taught is None or not {self._outputs[0], DISTANCE} & set(outputs):
            return self._network_means(inputs, contexts, *outputs)
        wanted = (self._outputs[0], FEATURES, *((DISTANCE,) if self.gives_distances else ()))
        found = dict(zip(wanted, self._network_means(inputs, contexts, *wanted), strict=True))
        nearest = _single(found[DISTANCE]) if self.gives_distances else None
        logits, nearest = self._taught.completed(found[wanted[0]], found[FEATURES], nearest)
        found[wanted[0]] = logits
        if nearest is not None:
            found[DISTANCE] = nearest[:, None]
        return [found[name] for name in outputs]

    def _network_means(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None, *outputs: str
    ) -> list[NDArray[np.float64]]:
        count, views = inputs.shape[:2]
        flat = inputs.reshape(count * views, *self.input_spec.input_shape)
        contexts = contexts_of(self.input_spec, inputs, contexts)
        repeated = None if contexts is None else np.repeat(contexts, views, axis=0)
        found = run_in_parts(self._session, flat, outputs, repeated)
        return [one.reshape(count, views, -1).mean(axis=1, dtype=np.float64) for one in found]


def _single(distances: NDArray[np.float64]) -> NDArray[np.float64]:
    if distances.shape[1] != 1:
        raise WeightsError(f"these weights give {distances.shape[1]} distances an input")
    return distances[:, 0]


def _own(
    file: Path, content: bytes, threads: int, input_spec: str | os.PathLike[str] | None
) -> OnnxClassifier:
    """The classifier in a user's file, from `circumspect export` or another program."""
    session, title = open_session(content, str(file), threads, foreign=True), str(file)
    description = description_in(session, title)
    if description is not None:
        if input_spec is not None:
            raise InputError(
                f"{input_spec}: {file} was made by circumspect export and holds its own input "
                "specification; leave this one out"
            )
        return _checked(session, description, title)
    given = None if input_spec is None else InputSpecFile.load(input_spec)
    spec = given or InputSpecFile.beside(file)
    if spec is None:
        beside = " or ".join(path.name for path in spec_paths(file))
        raise WeightsError(
            f"{file}: an ONNX network of another program; describe its input in {beside}, or make "
            "one with circumspect export"
        )
    try:
        adapted = ForeignSession(session, spec)
    except WeightsError as error:
        raise WeightsError(f"{file}: {error} ({spec.path.name})") from error
    return OnnxClassifier(adapted, spec.description(file.stem))


def _taught(file: Path, threads: int) -> OnnxClassifier:
    """A classifier with taught classes, together with its base."""
    taught = TaughtFile.load(file)
    path = taught.require_base(file)
    base = OnnxClassifier.load(taught.base if taught.base in SHIPPED else path, threads)
    try:
        return base.with_taught(taught.classes)
    except InputError as error:
        raise WeightsError(f"{file}: {error}; teach it again") from error


def _checked(session: Any, description: Any, name: str) -> OnnxClassifier:
    """The classifier, if the network fits its description."""
    try:
        classifier = OnnxClassifier(session, description)
    except LaterFormatError as error:
        raise WeightsError(f"{name}: {error}") from error
    except (ValueError, KeyError, TypeError, RecursionError, CircumspectError) as error:
        raise broken_description(name, error) from error
    try:
        check_shapes(
            session, classifier.input_spec.input_shape,
            len(classifier.classes) + (classifier.other is not None),
            classifier.input_spec.takes_context,
        )  # fmt: skip
    except WeightsError as error:
        raise WeightsError(f"{name}: {error}; export it again") from error
    return classifier
