"""Outputs of a network in ONNX Runtime: logits, probabilities, features and distances."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.context import contexts_of
from circumspect.classification.model_description import ModelDescription
from circumspect.classification.onnx_session import run_in_parts
from circumspect.classification.taught_classes import TaughtClasses
from circumspect.errors import WeightsError

FEATURES = "features"
"""Name of the output with the features of the last layer."""
DISTANCE = "distance"
"""Name of the output with the distance from the features of the nearest training object."""


class NetworkOutputs:
    """Runs a network and averages its outputs over views; taught classes extend them.

    Inputs are (n, views, *input_shape) as `InputSpec.inputs` makes them. Contexts are (n, 6) as
    `InputSpec.context` makes them; None means an unknown scale.

    Attributes:
        session: The network.
        description: Its classes, input and calibration.
        taught: Classes defined by examples; None without any.
    """

    def __init__(
        self, session: Any, description: ModelDescription, taught: TaughtClasses | None = None
    ) -> None:
        self.session, self.description, self.taught = session, description, taught
        self._names = [output.name for output in session.get_outputs()]

    @property
    def gives_features(self) -> bool:
        """Whether the network returns its features."""
        return FEATURES in self._names[1:]

    @property
    def gives_distances(self) -> bool:
        """Whether the network holds its training objects."""
        return DISTANCE in self._names[1:]

    @property
    def feature_width(self) -> Any:
        """Number of features; no number where the network does not state it."""
        return self.session.get_outputs()[self._names.index(FEATURES)].shape[1]

    def logits(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
    ) -> NDArray[np.float64]:
        """(n, columns) logits, with the column of other things."""
        (logits,) = self._means_over_views(inputs, contexts, self._names[0])
        return logits

    def logits_and_distances(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
        """(n, columns) logits, and (n,) distances or None where the network gives none."""
        if not self.gives_distances:
            return self.logits(inputs, contexts), None
        logits, distances = self._means_over_views(inputs, contexts, self._names[0], DISTANCE)
        return logits, _only_column(distances)

    def features(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
    ) -> NDArray[np.float64]:
        """(n, f) features of the last layer.

        Raises:
            WeightsError: The network does not return its features.
        """
        if not self.gives_features:
            raise WeightsError("these weights give no features; export them again")
        (features,) = self._means_over_views(inputs, contexts, FEATURES)
        return features

    def distances(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
    ) -> NDArray[np.float64]:
        """(n,) distances to the nearest training objects.

        Raises:
            WeightsError: The network does not hold its training objects.
        """
        if not self.gives_distances:
            raise WeightsError("these weights hold no training objects; use export --examples")
        (distances,) = self._means_over_views(inputs, contexts, DISTANCE)
        return _only_column(distances)

    def scores(self, logits: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, c) logits of the classes, divided by the temperature."""
        scores, other = self._scaled(logits), self.description.other
        return scores if other is None else np.delete(scores, other, axis=1)

    def softmax(
        self, logits: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(n, c) probabilities of the classes, and (n,) that of "other" beside them."""
        scores = self._scaled(logits)
        powers = np.exp(scores - scores.max(axis=1, keepdims=True))
        shares = powers / powers.sum(axis=1, keepdims=True)
        other = self.description.other
        if other is None:
            return shares, np.zeros(len(shares))
        named = np.delete(powers, other, axis=1)
        # A row of nothing but "other" also has a nearest class.
        named = np.maximum(named, np.finfo(np.float64).tiny)
        return named / named.sum(axis=1, keepdims=True), shares[:, other]

    def _scaled(self, logits: NDArray[np.float64]) -> NDArray[np.float64]:
        if logits.shape[1] != len(self.description.outputs):
            raise WeightsError(f"these weights give {logits.shape[1]} scores an input")
        return logits / self.description.temperature

    def _means_over_views(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None, *outputs: str
    ) -> list[NDArray[np.float64]]:
        """The outputs of the network, extended by the taught classes."""
        if self.taught is None or not {self._names[0], DISTANCE} & set(outputs):
            return self._network_means(inputs, contexts, *outputs)
        wanted = (self._names[0], FEATURES, *((DISTANCE,) if self.gives_distances else ()))
        found = dict(zip(wanted, self._network_means(inputs, contexts, *wanted), strict=True))
        nearest = _only_column(found[DISTANCE]) if self.gives_distances else None
        logits, nearest = self.taught.completed(found[wanted[0]], found[FEATURES], nearest)
        found[wanted[0]] = logits
        if nearest is not None:
            found[DISTANCE] = nearest[:, None]
        return [found[name] for name in outputs]

    def _network_means(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None, *outputs: str
    ) -> list[NDArray[np.float64]]:
        (count, views), input_spec = inputs.shape[:2], self.description.input_spec
        flat = inputs.reshape(count * views, *input_spec.input_shape)
        contexts = contexts_of(input_spec, inputs, contexts)
        repeated = None if contexts is None else np.repeat(contexts, views, axis=0)
        found = run_in_parts(self.session, flat, outputs, repeated)
        return [one.reshape(count, views, -1).mean(axis=1, dtype=np.float64) for one in found]


def _only_column(distances: NDArray[np.float64]) -> NDArray[np.float64]:
    if distances.shape[1] != 1:
        raise WeightsError(f"these weights give {distances.shape[1]} distances an input")
    return distances[:, 0]
