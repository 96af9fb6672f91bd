"""A classifier of your own, measured over yaws beside a shipped one.

python examples/06_own_classifier.py [OBJECTS_PER_CLASS]
"""

import sys

import numpy as np
from numpy.typing import ArrayLike

import circumspect as cs


class PowerClassifier(cs.Classifier):
    """The nearest class mean of the angular power spectrum, which does not know the yaw."""

    def __init__(self, objects: cs.ObjectSet) -> None:
        self._classes, self._input_spec = objects.classes, cs.GridSpec(shape=(16, 32, 16))
        inputs = [self.input_spec.inputs(objects.cloud(index)) for index in range(len(objects))]
        fingerprints = self._fingerprints(np.concatenate(inputs))
        each = [fingerprints[objects.labels == label] for label in range(len(self.classes))]
        self.means = np.array([found.mean(axis=0) for found in each])

    @property
    def classes(self) -> tuple[str, ...]:
        return self._classes

    @property
    def input_spec(self) -> cs.GridSpec:
        return self._input_spec

    def _fingerprints(self, inputs: np.ndarray) -> np.ndarray:
        grids = inputs.reshape(-1, *self.input_spec.shape).astype(float)
        power = np.abs(cs.angular_spectrum(grids, range(9)))
        return np.log(power + 0.01).reshape(len(grids), -1)

    def probabilities(self, inputs: np.ndarray, contexts: object = None) -> np.ndarray:  # noqa: ARG002
        gaps = np.linalg.norm(self._fingerprints(inputs)[:, None] - self.means, axis=2)
        likely = np.exp(gaps.min(axis=1, keepdims=True) - gaps)
        return likely / likely.sum(axis=1, keepdims=True)

    def classify(
        self,
        cloud: cs.PointCloud | ArrayLike,
        *,
        metric: bool = False,
        coverage: float | None = None,
    ) -> cs.Prediction:
        cloud = cs.as_cloud(cloud)
        grid = self.input_spec.bounds(cloud).hits(self.input_spec.surface(cloud))
        return self.classify_grid(grid, metric=metric, coverage=coverage)

    def classify_grid(
        self,
        *views: cs.OccupancyGrid,
        metric: bool = False,  # noqa: ARG002
        coverage: float | None = None,
    ) -> cs.Prediction:
        for grid in views:
            self.input_spec.accepts(grid)
        shares = self.probabilities(np.stack([grid.occupied for grid in views])).mean(axis=0)
        # The size is not used here. The coverage travels with the answer: it decides `confident`.
        return cs.Prediction.from_probabilities(self.classes, shares, coverage=coverage)


if __name__ == "__main__":
    each = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    train, test = cs.furniture_set(each), cs.furniture_set(max(each // 4, 1), first_seed=2_000_000)
    shipped = cs.Classifier.load("modelnet10")
    for name, rival in (("own", PowerClassifier(train)), ("modelnet10", shipped)):
        sweep = cs.sweep_yaw(rival, test, cs.spread_yaws(8))
        low, high = sweep.accuracy.min(), sweep.accuracy.max()
        print(f"{name:10} accuracy {low:.3f} to {high:.3f}, {sweep.flip_rate:.1%} flip over yaw")
