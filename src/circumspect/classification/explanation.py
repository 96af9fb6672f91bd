"""The evidence of an object together with the points that show it."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from circumspect.classification.evidence import CellEvidence, cell_evidence
from circumspect.classification.evidence_colours import evidence_colours, evidence_span
from circumspect.classification.grid_recipe import GridRecipe
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.geometry.coloured_ply import write_coloured_ply
from circumspect.grid import OccupancyGrid
from circumspect.grid.cell_centres import occupied_centres
from circumspect.storage import atomic_open


@dataclass(frozen=True, eq=False)
class Explanation:
    """Evidence, and where it lies on the object.

    Attributes:
        evidence: Of each cell.
        surface: Points in the frame of the grid: those of a cloud without holes, or the centres
            of a grid's occupied cells.
        shown: What was asked about.
    """

    evidence: CellEvidence
    surface: PointCloud
    shown: PointCloud | OccupancyGrid

    def save_ply(self, path: str | os.PathLike[str]) -> None:
        """Write the surface in the colours of its evidence, with the property `evidence`.

        Raises:
            OutputError: The file can not be written.
        """
        values = self.evidence.at(self.surface)
        colours = evidence_colours(values, evidence_span(self.evidence.cells))
        write_coloured_ply(path, self.surface, colours, values, "evidence")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as npz: `evidence` and `states` of the cells, the grid's bounds, the answer.

        Raises:
            OutputError: The file can not be written.
        """
        explained = self.evidence
        bounds: dict[str, Any] = {
            name: np.asarray(value)
            for name, value in vars(explained.grid.grid).items()
            if name != "shape"
        }
        answer = explained.prediction.probabilities
        with atomic_open(path, "wb") as stream:
            np.savez_compressed(
                stream,
                evidence=explained.cells,
                states=explained.grid.states,
                label=np.array([explained.label]),
                log_odds=np.array([explained.log_odds]),
                classes=np.array(list(answer)),
                probabilities=np.array(list(answer.values())),
                **bounds,
            )


def explain_cloud(
    classifier: OnnxClassifier,
    cloud: PointCloud,
    label: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    metric: bool = False,
) -> Explanation:
    """Explain what a classifier says of a cloud.

    The answer is that of `classify`, over all views of the recipe; the evidence is asked for on
    the first of its grids.

    Args:
        classifier: Of grids.
        cloud: The object's surface, z up.
        label: The class to ask about; None means the one that is named.
        progress: Called with (done, all) grids.
        metric: The points are in metres; without it their scale counts as unknown.

    Raises:
        InputError: The classifier takes points, or does not know the label; or an implausible size
            in metres.
        GeometryError: The points span no shape.
    """
    recipe = classifier.recipe
    if not isinstance(recipe, GridRecipe):
        raise InputError("these weights take points; only those that take grids are explained")
    prediction = classifier.classify(cloud, metric=metric)
    surface = recipe.surface(cloud)
    grid = recipe.bounds(cloud).hits(surface.points_xyz)
    found = cell_evidence(
        classifier, grid, label or prediction.label, progress=progress, metric=metric
    )
    return Explanation(replace(found, prediction=prediction), surface, cloud)


def explain_grid(
    classifier: OnnxClassifier,
    grid: OccupancyGrid,
    label: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    metric: bool = False,
) -> Explanation:
    """Explain what a classifier says of a grid; see `explain_cloud`.

    Raises:
        InputError: Another kind or shape than the classifier takes, or nothing in it.
    """
    found = cell_evidence(classifier, grid, label, progress=progress, metric=metric)
    return Explanation(found, PointCloud(occupied_centres(grid)), grid)


def half_share(explained: CellEvidence) -> float:
    """The smallest share of the occupied cells that holds half of what speaks for the class."""
    positive = np.sort(explained.cells[explained.cells > 0])[::-1].astype(np.float64)
    if not positive.size:
        return 0.0
    held = np.cumsum(positive)
    needed = int(np.searchsorted(held, held[-1] / 2)) + 1
    return needed / int(explained.grid.occupied.sum())
