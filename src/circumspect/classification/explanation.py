"""The evidence of an object together with the points that show it."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace

from circumspect.classification.evidence import CellEvidence, cell_evidence
from circumspect.classification.evidence_plot import evidence_colours, evidence_span
from circumspect.classification.grid_spec import GridSpec
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.geometry.formats.ply_file import write_coloured_ply
from circumspect.grid import OccupancyGrid
from circumspect.grid.cell_centres import occupied_centres


@dataclass(frozen=True, eq=False)
class Explanation:
    """Evidence, and where it lies on the object.

    Attributes:
        evidence: Of each cell.
        surface: Points in the frame of the grid: those of a cloud without holes, or the centres
            of a grid's occupied cells.
        shown: The object.
    """

    evidence: CellEvidence
    surface: PointCloud
    shown: PointCloud | OccupancyGrid

    def save_ply(self, path: str | os.PathLike[str]) -> None:
        """Write the surface in the colours of its evidence, with the property `evidence`.

        Raises:
            OutputError: The file cannot be written.
        """
        values = self.evidence.at(self.surface)
        colours = evidence_colours(values, evidence_span(self.evidence.cells))
        write_coloured_ply(path, self.surface, colours, values, "evidence")


def explain_cloud(
    classifier: OnnxClassifier,
    cloud: PointCloud,
    label: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    metric: bool = False,
) -> Explanation:
    """Compute the evidence for the class of a cloud.

    The answer is that of `classify`, over all views. The evidence is that of the first grid.

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
    input_spec = classifier.input_spec
    if not isinstance(input_spec, GridSpec):
        raise InputError("these weights take points; only those that take grids are explained")
    prediction = classifier.classify(cloud, metric=metric)
    surface = input_spec.surface(cloud)
    grid = input_spec.bounds(cloud).hits(surface.points_xyz)
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
