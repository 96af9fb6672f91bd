"""A classifier with known answers, by the share of occupied cells."""

from __future__ import annotations

import numpy as np

from circumspect.classification import Classifier, GridSpec, Prediction
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.geometry import PointCloud
from circumspect.grid import OccupancyGrid


class VolumeClassifier(Classifier):
    """Predicts "full" with the share of occupied cells as its probability."""

    def __init__(self, rule: ConfidenceRule | None = None) -> None:
        self.grids: list[OccupancyGrid] = []
        self.rule = rule or ConfidenceRule()

    @property
    def classes(self) -> tuple[str, ...]:
        return ("empty", "full")

    @property
    def input_spec(self) -> GridSpec:
        return GridSpec(shape=(16, 16, 16))

    def classify(
        self, cloud: PointCloud, *, metric: bool = False, coverage: float | None = None
    ) -> Prediction:
        grid = self.input_spec.bounds(cloud).hits(cloud)
        return self.classify_grid(grid, metric=metric, coverage=coverage)

    def classify_grid(
        self, *views: OccupancyGrid, metric: bool = False, coverage: float | None = None
    ) -> Prediction:
        assert metric, "the pipeline works in metres"
        for grid in views:
            self.input_spec.accepts(grid)
        self.grids.append(views[0])
        share = float(np.mean([grid.occupied for grid in views]))
        shares = np.array([1 - share, share])
        return Prediction.from_probabilities(
            self.classes, shares, coverage=coverage, rule=self.rule
        )
