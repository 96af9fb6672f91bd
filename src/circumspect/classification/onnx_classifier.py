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
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.context import contexts_of
from circumspect.classification.foreign_session import ForeignSession
from circumspect.classification.grid_recipe import GridRecipe
from circumspect.classification.input_recipe import InputRecipe
from circumspect.classification.input_spec_file import InputSpecFile, spec_paths
from circumspect.classification.model_description import LaterFormatError, ModelDescription
from circumspect.classification.one_object import is_one_object
from circumspect.classification.onnx_file import (
    broken_description,
    description_in,
    foreign_network,
    open_session,
    shipped_network,
)
from circumspect.classification.onnx_session import check_shapes, run_in_parts
from circumspect.classification.open_set import OpenSetRule
from circumspect.classification.plausible_size import require_plausible_size
from circumspect.classification.prediction import Prediction
from circumspect.classification.shipped import SHIPPED, model_path, shipped_name
from circumspect.classification.taught_classes import TaughtClass, TaughtClasses
from circumspect.classification.taught_file import SUFFIX, TaughtFile
from circumspect.errors import CircumspectError, InputError, WeightsError
from circumspect.geometry import PointCloud
from circumspect.geometry.given_cloud import as_cloud
from circumspect.grid import OccupancyGrid

FEATURES = "features"
"""Name of the output that tells what the last layer sees …"""
DISTANCE = "distance"
"""… and of the one that tells how far that is from what it saw of any training object."""


class OnnxClassifier(Classifier):
    """Runs a network that `circumspect export` wrote; see `Classifier`."""

    def __init__(
        self, session: Any, description: dict[str, Any], taught: TaughtClasses | None = None
    ) -> None:
        self._session, self._taught = session, taught
        self.description = description
        """What the file says of itself: name, classes, grid, temperature, training and, with its
        training objects, unknown_beyond."""
        self._described = ModelDescription.from_dict(description)
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
        # Absolute: never a shipped name, and the same file wherever it is loaded again.
        spec = None if input_spec is None else str(Path(input_spec).absolute())
        own._loaded_with = (str(file.absolute()), threads, spec)
        return own

    def with_taught(self, classes: Sequence[TaughtClass]) -> OnnxClassifier:
        """The same classifier with classes that it was taught, in the place of earlier ones.

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
        """The classes that it was taught."""
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
        recipe = self.recipe
        shape = "x".join(map(str, recipe.input_shape)).removeprefix("1x")  # Of its only channel.
        views = f"{recipe.azimuth_views} view{'' if recipe.azimuth_views == 1 else 's'}"
        if isinstance(recipe, GridRecipe) and recipe.staggered:
            views = f"{recipe.azimuth_views} staggered views"
        return f"OnnxClassifier({len(self.classes)} classes, {recipe.kind} {shape}, {views})"

    @property
    def classes(self) -> tuple[str, ...]:
        """See `Classifier.classes`."""
        return self._described.classes

    @property
    def recipe(self) -> InputRecipe:
        """See `Classifier.recipe`."""
        return self._described.recipe

    @property
    def temperature(self) -> float:
        """What the logits are divided by."""
        return self._described.temperature

    @property
    def training(self) -> Mapping[str, Any]:
        """How it was trained; empty where the file does not say."""
        told = self.description.get("training")
        return told if isinstance(told, dict) else {}

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
        inputs = self.recipe.inputs(cloud)
        bounds = self.recipe.bounds(cloud) if metric and self.recipe.metric else None
        context = self.recipe.context(inputs[0], bounds)
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
            self.recipe.accepts(grid)
        recipe = self.recipe
        inputs = np.stack([recipe.input_of(grid) for grid in views])
        context = recipe.context(inputs, views[0].grid if metric else None)
        return self._prediction(inputs[None], context, {}, coverage)

    def _prediction(
        self,
        inputs: NDArray[Any],
        context: NDArray[np.float32] | None,
        milliseconds: Mapping[str, float],
        coverage: float | None,
    ) -> Prediction:
        """Of one object."""
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
        """Name one object as it is shown to the network.

        Args:
            inputs: (1, views, *input_shape) as `recipe.inputs` makes them.
            context: (6,) as `recipe.context` makes it; None means an unknown scale.
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
            inputs: (n, views, *input_shape) as `recipe.inputs` makes them; logits are averaged
                over views.
            contexts: (n, 6) as `recipe.context` makes them; None means an unknown scale.

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
        # A row of nothing but "other" still has a nearest class.
        named = np.maximum(named, np.finfo(np.float64).tiny)
        return named / named.sum(axis=1, keepdims=True), shares[:, other]

    def scores(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Logits of many objects, divided by the temperature: their softmax is the probabilities.

        Args:
            inputs: (n, views, *input_shape) as `recipe.inputs` makes them.
            contexts: (n, 6) as `recipe.context` makes them; None means an unknown scale.

        Returns:
            (n, c), averaged over views.
        """
        (logits,) = self._means_over_views(inputs, contexts, self._outputs[0])
        scores, other = self._scores(logits), self._described.other
        return scores if other is None else np.delete(scores, other, axis=1)

    def open_set_signs(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
        """What `OpenSetRule` joins.

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
        """How objects of other kinds are recognised; None for files without such a model."""
        return self._described.open_set

    @property
    def other(self) -> str | None:
        """Name of the network's class of other things, which is never a label."""
        column = self._described.other
        return None if column is None else self._described.outputs[column]

    def features(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """What the network's last layer sees of many objects: near where they look alike to it.

        Args:
            inputs: (n, views, *input_shape) as `recipe.inputs` makes them.
            contexts: (n, 6) as `recipe.context` makes them; None means an unknown scale.

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
        """How far many objects are from the training objects nearest to them, see `NearExample`.

        Args:
            inputs: (n, views, *input_shape) as `recipe.inputs` makes them.
            contexts: (n, 6) as `recipe.context` makes them; None means an unknown scale.

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
        """The outputs of the network, completed by the classes that it was taught."""
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
        flat = inputs.reshape(count * views, *self.recipe.input_shape)
        contexts = contexts_of(self.recipe, inputs, contexts)
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
    """The classifier in a user's file: of `circumspect export`, or of another program."""
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
    """A classifier that was taught, with the one that it was taught to."""
    taught = TaughtFile.load(file)
    path = taught.require_base(file)
    base = OnnxClassifier.load(taught.base if taught.base in SHIPPED else path, threads)
    try:
        return base.with_taught(taught.classes)
    except InputError as error:
        raise WeightsError(f"{file}: {error}; teach it again") from error


def _checked(session: Any, description: Any, name: str) -> OnnxClassifier:
    """The classifier, if the network takes and gives what is described."""
    try:
        classifier = OnnxClassifier(session, description)
    except LaterFormatError as error:
        raise WeightsError(f"{name}: {error}") from error
    except (ValueError, KeyError, TypeError, RecursionError, CircumspectError) as error:
        raise broken_description(name, error) from error
    try:
        check_shapes(
            session, classifier.recipe.input_shape,
            len(classifier.classes) + (classifier.other is not None),
            classifier.recipe.takes_context,
        )  # fmt: skip
    except WeightsError as error:
        raise WeightsError(f"{name}: {error}; export it anew") from error
    return classifier
