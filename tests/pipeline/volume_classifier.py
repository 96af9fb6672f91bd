"""A classifier simple enough to know its answers: by how many cells are occupied."""

from __future__ import annotations

import numpy as np

from circumspect.classification import Classifier, GridRecipe, Prediction
from circumspect.geometry import PointCloud
from circumspect.grid import OccupancyGrid


class VolumeClassifier(Classifier):
    """Says "full" with the share of occupied cells as its probability."""

    def __init__(self) -> None:
        self.grids: list[OccupancyGrid] = []

    @property
    def classes(self) -> tuple[str, ...]:
        return ("empty", "full")

    @property
    def recipe(self) -> GridRecipe:
        return GridRecipe(shape=(16, 16, 16))

    def classify(self, cloud: PointCloud) -> Prediction:
        return self.classify_grid(self.recipe.bounds(cloud).hits(cloud))

    def classify_grid(self, *views: OccupancyGrid) -> Prediction:
        for grid in views:
            self.recipe.accepts(grid)
        self.grids.append(views[0])
        share = float(np.mean([grid.occupied for grid in views]))
        return Prediction.from_probabilities(self.classes, np.array([1 - share, share]))
