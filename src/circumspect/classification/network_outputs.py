"""Outputs of a network for many objects: logits, features and distances, averaged over views."""

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
    """Runs a network, extended by taught classes.

    Inputs are (n, views, *input_shape), contexts (n, 6) or None for an unknown scale.

    Attributes:
        session: The network in ONNX Runtime.
        taught: The taught classes; None for none.
        gives_features: Whether the network returns its features.
        gives_distances: Whether it returns distances from its training objects.
    """

    def __init__(
        self, session: Any, description: ModelDescription, taught: TaughtClasses | None = None
    ) -> None:
        self.session, self.taught, self._described = session, taught, description
        outputs = session.get_outputs()
        self._logits = outputs[0].name
        widths = {output.name: output.shape[1:] for output in outputs[1:]}
        self.gives_features, self.gives_distances = FEATURES in widths, DISTANCE in widths
        self._feature_width = widths.get(FEATURES)

    @property
    def feature_width(self) -> int:
        """Numbers per feature.

        Raises:
            WeightsError: The network returns no features.
        """
        if self._feature_width is None:
            raise WeightsError("these weights give no features; export them again")
        return int(self._feature_width[0])

    def logits(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
    ) -> NDArray[np.float64]:
        """(n, c) logits."""
        return self._means(inputs, contexts, self._logits)[0]

    def logits_and_distances(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
        """(n, c) logits, and (n,) distances; None if the network returns none."""
        if not self.gives_distances:
            return self.logits(inputs, contexts), None
        logits, distances = self._means(inputs, contexts, self._logits, DISTANCE)
        return logits, _single(distances)

    def features(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
    ) -> NDArray[np.float64]:
        """(n, f) features.

        Raises:
            WeightsError: The network returns none.
        """
        if not self.gives_features:
            raise WeightsError("these weights give no features; export them again")
        return self._means(inputs, contexts, FEATURES)[0]

    def distances(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None
    ) -> NDArray[np.float64]:
        """(n,) distances from the nearest training objects.

        Raises:
            WeightsError: The network returns none.
        """
        if not self.gives_distances:
            raise WeightsError("these weights hold no training objects; use export --examples")
        return _single(self._means(inputs, contexts, DISTANCE)[0])

    def scores(self, logits: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, c) logits, divided by the temperature.

        Raises:
            WeightsError: The description names another number of classes.
        """
        if logits.shape[1] != len(self._described.outputs):
            raise WeightsError(f"these weights give {logits.shape[1]} scores an input")
        return logits / self._described.temperature

    def probabilities(
        self, logits: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(n, c) probabilities of the classes, and (n,) that of "other" beside them."""
        scores = self.scores(logits)
        powers = np.exp(scores - scores.max(axis=1, keepdims=True))
        shares = powers / powers.sum(axis=1, keepdims=True)
        other = self._described.other
        if other is None:
            return shares, np.zeros(len(shares))
        named = np.delete(powers, other, axis=1)
        # A row of nothing but "other" also has a nearest class.
        named = np.maximum(named, np.finfo(np.float64).tiny)
        return named / named.sum(axis=1, keepdims=True), shares[:, other]

    def _means(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None, *outputs: str
    ) -> list[NDArray[np.float64]]:
        """The outputs of the network, extended by the taught classes."""
        if self.taught is None or not {self._logits, DISTANCE} & set(outputs):
            return self._network_means(inputs, contexts, *outputs)
        wanted = (self._logits, FEATURES, *((DISTANCE,) if self.gives_distances else ()))
        found = dict(zip(wanted, self._network_means(inputs, contexts, *wanted), strict=True))
        nearest = _single(found[DISTANCE]) if self.gives_distances else None
        logits, nearest = self.taught.completed(found[self._logits], found[FEATURES], nearest)
        found[self._logits] = logits
        if nearest is not None:
            found[DISTANCE] = nearest[:, None]
        return [found[name] for name in outputs]

    def _network_means(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None, *outputs: str
    ) -> list[NDArray[np.float64]]:
        count, views = inputs.shape[:2]
        input_spec = self._described.input_spec
        flat = inputs.reshape(count * views, *input_spec.input_shape)
        contexts = contexts_of(input_spec, inputs, contexts)
        repeated = None if contexts is None else np.repeat(contexts, views, axis=0)
        found = run_in_parts(self.session, flat, outputs, repeated)
        return [one.reshape(count, views, -1).mean(axis=1, dtype=np.float64) for one in found]


def _single(distances: NDArray[np.float64]) -> NDArray[np.float64]:
    if distances.shape[1] != 1:
        raise WeightsError(f"these weights give {distances.shape[1]} distances an input")
    return distances[:, 0]
