"""A classifier in ONNX Runtime."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.classification.classifier import Classifier
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.context import contexts_of
from circumspect.classification.floor_left import holds_floor
from circumspect.classification.grid_recipe import GridRecipe
from circumspect.classification.input_recipe import InputRecipe
from circumspect.classification.onnx_inspection import (
    LARGEST_FILE,
    bound_memory,
    require_plain_network,
)
from circumspect.classification.onnx_session import check_shapes, run_in_parts
from circumspect.classification.open_set import OpenSetRule
from circumspect.classification.plausible_size import require_plausible_size
from circumspect.classification.prediction import Prediction
from circumspect.classification.recipes import recipe_from_dict
from circumspect.classification.shipped import shipped_name, shipped_path, unknown_model
from circumspect.errors import CircumspectError, InputError, WeightsError, reason_of
from circumspect.geometry import PointCloud
from circumspect.geometry.given_cloud import as_cloud
from circumspect.grid import OccupancyGrid

METADATA_KEY = "circumspect"
FORMAT = 2
"""Of what a file says of itself: 2 knows visibility, metric size, an open set and confidence."""
OBJECTS = "objects"
"""What a network's record of its training calls the names of those that it was fitted to."""
MOST_THREADS = 1024
FEWEST_POINTS = 128
"""A cloud of fewer distinct ones is never `known` to a classifier that tells the unknown: three
points are near enough to some training object, too; measured by `benchmarks.few_points`."""
FEATURES = "features"
"""Name of the output that tells what the last layer sees …"""
DISTANCE = "distance"
"""… and of the one that tells how far that is from what it saw of any training object."""


class OnnxClassifier(Classifier):
    """Runs a network that `circumspect export` wrote; see `Classifier`."""

    def __init__(self, session: Any, description: dict[str, Any]) -> None:
        self._session = session
        self.description = description
        """What the file says of itself: name, classes, grid, temperature, training and, with its
        training objects, unknown_beyond."""
        _require_known_format(description)
        self._outputs_classes = _checked_classes(description)
        self._other = _other_column(description, self._outputs_classes)
        self._classes = tuple(
            name for column, name in enumerate(self._outputs_classes) if column != self._other
        )
        self._recipe = recipe_from_dict(description["grid"])
        self._temperature = checked_temperature(description.get("temperature", 1.0))
        beyond = description.get("unknown_beyond")
        self._unknown_beyond = np.inf if beyond is None else checked_distance(beyond)
        open_set = description.get("open_set")
        self._open_set = None if open_set is None else OpenSetRule.from_dict(open_set)
        self._rule = ConfidenceRule.from_dict(description.get("confidence"))
        self._outputs = [output.name for output in session.get_outputs()]
        self._loaded_with: tuple[str, int] | None = None

    @staticmethod
    def load(model: str | os.PathLike[str] | None = None, threads: int = 0) -> OnnxClassifier:
        """See `Classifier.load`."""
        name = shipped_name(model)
        if name is not None:
            shipped = _open(_shipped(name), f"the classifier '{name}'", threads)
            shipped._loaded_with = (name, threads)
            return shipped
        content = _read(model or "")
        try:
            require_plain_network(content)
        except WeightsError as error:
            raise WeightsError(
                f"{model}: not an ONNX network that can be run ({error}); make one with "
                "circumspect export"
            ) from error
        own = _open(content, str(model), threads, foreign=True)
        # Absolute: never a shipped name, and the same file wherever it is loaded again.
        own._loaded_with = (str(Path(model or "").absolute()), threads)
        return own

    def __reduce__(self) -> tuple[Callable[..., OnnxClassifier], tuple[str, int]]:
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
        recipe = self._recipe
        shape = "x".join(map(str, recipe.input_shape)).removeprefix("1x")  # Of its only channel.
        views = f"{recipe.azimuth_views} view{'' if recipe.azimuth_views == 1 else 's'}"
        if isinstance(recipe, GridRecipe) and recipe.staggered:
            views = f"{recipe.azimuth_views} staggered views"
        return f"OnnxClassifier({len(self._classes)} classes, {recipe.kind} {shape}, {views})"

    @property
    def classes(self) -> tuple[str, ...]:
        """See `Classifier.classes`."""
        return self._classes

    @property
    def recipe(self) -> InputRecipe:
        """See `Classifier.recipe`."""
        return self._recipe

    @property
    def temperature(self) -> float:
        """What the logits are divided by."""
        return self._temperature

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
        inputs = self._recipe.inputs(cloud)
        bounds = self._recipe.bounds(cloud) if metric and self._recipe.metric else None
        context = self._recipe.context(inputs[0], bounds)
        times = {"grid": 1e3 * (time.perf_counter() - start)}
        prediction = self._prediction(inputs, context, times, coverage)
        if self._tells_unknown and not _is_one_object(cloud.points_xyz):
            return replace(prediction, in_distribution=False)
        return prediction

    @property
    def _tells_unknown(self) -> bool:
        return self._open_set is not None or bool(np.isfinite(self._unknown_beyond))

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
            self._recipe.accepts(grid)
        recipe = self._recipe
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
        if self._open_set is not None:
            belongs = float(self._open_set.probability(other[0], distance))
            known = belongs >= self._open_set.threshold
        else:
            known = distance is None or distance <= self._unknown_beyond
        return Prediction.from_probabilities(
            self._classes, probabilities[0], times, in_distribution=known, distance=distance,
            coverage=coverage, rule=self._rule, in_distribution_probability=belongs,
        )  # fmt: skip

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
        if self._other is None:
            return shares, np.zeros(len(shares))
        named = np.delete(powers, self._other, axis=1)
        # A row of nothing but "other" still has a nearest class.
        named = np.maximum(named, np.finfo(np.float64).tiny)
        return named / named.sum(axis=1, keepdims=True), shares[:, self._other]

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
        scores = self._scores(logits)
        return scores if self._other is None else np.delete(scores, self._other, axis=1)

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
        if logits.shape[1] != len(self._outputs_classes):
            raise WeightsError(f"these weights give {logits.shape[1]} scores an input")
        return logits / self._temperature

    @property
    def rule(self) -> ConfidenceRule:
        """The bounds that make an answer confident."""
        return self._rule

    @property
    def open_set(self) -> OpenSetRule | None:
        """How objects of other kinds are recognised; None for files without such a model."""
        return self._open_set

    @property
    def other(self) -> str | None:
        """Name of the network's class of other things, which is never a label."""
        return None if self._other is None else self._outputs_classes[self._other]

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
            raise WeightsError("these weights give no features; export them anew")
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
        count, views = inputs.shape[:2]
        flat = inputs.reshape(count * views, *self._recipe.input_shape)
        contexts = contexts_of(self._recipe, inputs, contexts)
        repeated = None if contexts is None else np.repeat(contexts, views, axis=0)
        found = run_in_parts(self._session, flat, outputs, repeated)
        return [one.reshape(count, views, -1).mean(axis=1, dtype=np.float64) for one in found]


def _is_one_object(points: NDArray[np.float64]) -> bool:
    """Whether there is enough of it, and no floor beneath."""
    return _are_distinct(points, FEWEST_POINTS) and not holds_floor(points)


def _are_distinct(points: NDArray[np.float64], fewest: int) -> bool:
    """Whether so many of them lie in different places."""
    # Of large clouds the first points tell, unless they are repeated.
    return any(len(np.unique(part, axis=0)) >= fewest for part in (points[: 8 * fewest], points))


def _single(distances: NDArray[np.float64]) -> NDArray[np.float64]:
    if distances.shape[1] != 1:
        raise WeightsError(f"these weights give {distances.shape[1]} distances an input")
    return distances[:, 0]


def _require_known_format(description: Any) -> None:
    """That a file is not of a later version than this program."""
    number = description.get("format", 1) if isinstance(description, dict) else 1
    if isinstance(number, bool) or not isinstance(number, int) or number < 1:
        raise WeightsError(f"its input format is {number!r:.20}, not a whole number")
    if number > FORMAT:
        raise WeightsError(
            f"its input format is {number}, this version reads up to {FORMAT}; update circumspect"
        )


def _other_column(description: dict[str, Any], classes: tuple[str, ...]) -> int | None:
    """The output that stands for other things."""
    other = description.get("other")
    if other is None:
        return None
    if other not in classes or len(classes) < 2:
        raise WeightsError(f"its class of other things, {other!r:.40}, is none of its classes")
    return classes.index(other)


def _checked_classes(description: Any) -> tuple[str, ...]:
    if not isinstance(description, dict):
        raise WeightsError("its description is no object")
    classes = description["classes"]
    names = isinstance(classes, list) and all(isinstance(name, str) for name in classes)
    if not names or not all(0 < len(name) <= 200 and name.isprintable() for name in classes):
        raise WeightsError("its classes are not names")
    if not classes or len(set(classes)) != len(classes):
        raise WeightsError(f"its classes are not distinct: {', '.join(classes)[:200]}")
    return tuple(classes)


def checked_temperature(value: Any) -> float:
    """A divisor of logits.

    Raises:
        InputError: Not a positive finite number.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < np.inf:
        raise InputError(f"the temperature must be a positive number, not {value!r}")
    return float(value)


def _read(model: str | os.PathLike[str]) -> bytes:
    path = Path(model)
    try:
        if not os.fspath(model):
            raise FileNotFoundError
        if path.is_dir():
            raise WeightsError(
                f"{path}: is a folder; where a network was trained in it, circumspect export "
                "makes the ONNX file that is needed here"
            )
        if path.exists() and not path.is_file():
            raise WeightsError(f"{path}: can not be read (not a regular file)")
        if path.is_file() and path.stat().st_size > LARGEST_FILE:
            raise WeightsError(f"{path}: larger than {LARGEST_FILE >> 20} MiB; no network here is")
        return path.read_bytes()
    except FileNotFoundError as error:
        raise unknown_model(model) from error
    except OSError as error:
        raise WeightsError(f"{path}: can not be read ({reason_of(error)})") from error


def checked_distance(value: Any) -> float:
    """A distance from the nearest training object beyond which an object is called unknown.

    Raises:
        InputError: Not within 0 … 2.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 2:
        raise InputError(f"the distance of the unknown must lie in 0 … 2, not {value!r}")
    return float(value)


def _shipped(name: str) -> bytes:
    try:
        return shipped_path(name).read_bytes()
    except OSError as error:
        raise WeightsError(
            f"the shipped classifier '{name}' is missing; install circumspect again"
        ) from error


def _open(content: bytes, name: str, threads: int, foreign: bool = False) -> OnnxClassifier:
    import onnxruntime

    if not 0 <= threads <= MOST_THREADS:
        raise InputError(f"threads must be 0 (all cores) to {MOST_THREADS}, not {threads}")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    # Threads that wait would keep the cores from the stages before and after.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.log_severity_level = 4
    if foreign:
        bound_memory()
        options.add_session_config_entry("session.use_env_allocators", "1")
    try:
        session = onnxruntime.InferenceSession(content, options, ["CPUExecutionProvider"])
    # ONNX Runtime's faults share no base class of their own.
    except Exception as error:
        raise WeightsError(
            f"{name}: not an ONNX network; make one with circumspect export"
        ) from error
    try:
        text = session.get_modelmeta().custom_metadata_map.get(METADATA_KEY)
    except UnicodeDecodeError as error:
        raise WeightsError(f"{name}: its description is no text; export it anew") from error
    if text is None:
        raise WeightsError(f"{name}: an ONNX network of another program; use circumspect export")
    try:
        classifier = OnnxClassifier(session, json.loads(text))
    except (ValueError, KeyError, TypeError, RecursionError, CircumspectError) as error:
        raise WeightsError(
            f"{name}: its description is broken ({error}); export it anew"
        ) from error
    try:
        check_shapes(
            session, classifier.recipe.input_shape,
            len(classifier.classes) + (classifier.other is not None),
            classifier.recipe.takes_context,
        )  # fmt: skip
    except WeightsError as error:
        raise WeightsError(f"{name}: {error}; export it anew") from error
    return classifier
