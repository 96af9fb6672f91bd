"""Which cells carry a decision: cells are emptied, and the answer is asked anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.classification.occlusion_blocks import Block, occupied_blocks
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.prediction import Prediction
from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.grid import OccupancyGrid

EDGES = (0.5, 0.25)
"""Of the blocks [grid radii]: parts of an object, and parts of those."""
BATCH = 32


@dataclass(frozen=True, eq=False)
class CellEvidence(ReadOnlyArrays):
    """What each occupied cell of a grid says for a class.

    Attributes:
        grid: What was shown.
        prediction: The answer to it.
        label: The class that the evidence is for or against.
        log_odds: ln(p / (1 - p)) of that class, all cells in place.
        cells: float32 of the grid's shape, 0 where nothing is: by how much the log-odds fall when
            the cell's neighbourhood is emptied. Above 0 the cells speak for the class, below
            against it.
        asked: How many changed grids the classifier was shown.
    """

    grid: OccupancyGrid
    prediction: Prediction
    label: str
    log_odds: float
    cells: NDArray[np.float32]
    asked: int

    def at(self, points_xyz: PointCloud | ArrayLike) -> NDArray[np.float32]:
        """The evidence of the cells that points lie in.

        Args:
            points_xyz: (n, 3) [m] in the frame of the grid.

        Returns:
            (n,) float32; 0 outside the grid and in cells that are not occupied.

        Raises:
            GeometryError: NaN or infinite coordinates.
        """
        indices = self.grid.grid.indices(points_xyz)
        found = self.cells[tuple(indices.T)]
        return np.where(indices[:, 0] >= 0, found, np.float32(0))


def cell_evidence(
    classifier: OnnxClassifier,
    grid: OccupancyGrid,
    label: str | None = None,
    edges: Sequence[float] = EDGES,
    progress: Callable[[int, int], None] | None = None,
) -> CellEvidence:
    """Ask a classifier again and again, each time with another block of cells emptied.

    The evidence of a cell is the mean fall of the log-odds over the blocks that hold it, then the
    mean over the sizes of blocks.

    Args:
        classifier: Of grids.
        grid: An object as the classifier's recipe grids it.
        label: The class to ask about; None means the one that the classifier names.
        edges: Sizes of the blocks, as shares of the grid's radius or half width.
        progress: Called with (done, all) grids.

    Raises:
        InputError: A grid of another kind or shape than the classifier takes, an empty one, an
            unknown label, or an edge out of range.
    """
    prediction = classifier.classify_grid(grid)
    column = _column(classifier, prediction.label if label is None else label)
    occupied = grid.occupied
    if not edges:
        raise InputError("give at least one size of blocks")
    blocks = [occupied_blocks(grid, edge) for edge in edges]
    changed, which = _distinct(occupied, [block for sized in blocks for block in sized])
    before = log_odds(classifier.scores(_inputs(occupied[None])))[0, column]
    after = _asked(classifier, occupied.shape, changed, column, progress)
    falls = (before - after)[which]
    cells = np.zeros(occupied.shape)
    start = 0
    for sized in blocks:
        cells += _mean_fall(occupied, sized, falls[start : start + len(sized)]) / len(edges)
        start += len(sized)
    found = cells.astype(np.float32)
    found.flags.writeable = False
    name = classifier.classes[column]
    return CellEvidence(grid, prediction, name, float(before), found, len(changed))


def log_odds(scores: NDArray[np.float64]) -> NDArray[np.float64]:
    """ln(p / (1 - p)) of each class: unlike p, it does not saturate where an answer is sure.

    Args:
        scores: (n, c), c at least 2, whose softmax is p.

    Returns:
        (n, c).
    """
    others = np.empty_like(scores)
    for column in range(scores.shape[1]):
        rest = np.delete(scores, column, axis=1)
        others[:, column] = np.logaddexp.reduce(rest, axis=1)
    return scores - others


def _column(classifier: OnnxClassifier, label: str) -> int:
    if label not in classifier.classes:
        raise InputError(f"no class {label!r}; known: {', '.join(classifier.classes)}")
    if len(classifier.classes) < 2:
        raise InputError("a classifier of one class has nothing to decide")
    return classifier.classes.index(label)


def _distinct(
    occupied: NDArray[np.bool_], blocks: Sequence[Block]
) -> tuple[NDArray[np.uint8], NDArray[np.intp]]:
    """Packed grids, each with a block emptied, and for every block the number of its grid."""
    packed = np.empty((len(blocks), (occupied.size + 7) // 8), np.uint8)
    for row, block in zip(packed, blocks, strict=True):
        left = occupied.copy()
        left[block.cells] = False
        row[:] = np.packbits(left)
    changed, which = np.unique(packed, axis=0, return_inverse=True)
    return changed, which.reshape(-1)


def _asked(
    classifier: OnnxClassifier,
    shape: tuple[int, ...],
    changed: NDArray[np.uint8],
    column: int,
    progress: Callable[[int, int], None] | None,
) -> NDArray[np.float64]:
    """(n,) log-odds of a class in n packed grids."""
    found = np.empty(len(changed))
    cells = int(np.prod(shape))
    for start in range(0, len(changed), BATCH):
        part = slice(start, start + BATCH)
        grids = np.unpackbits(changed[part], axis=1, count=cells).reshape(-1, *shape)
        found[part] = log_odds(classifier.scores(_inputs(grids)))[:, column]
        if progress is not None:
            progress(min(start + BATCH, len(changed)), len(changed))
    return found


def _inputs(grids: NDArray[np.bool_] | NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(n, *shape) as objects of one view and one channel."""
    return grids.astype(np.uint8, copy=False)[:, None, None]


def _mean_fall(
    occupied: NDArray[np.bool_], blocks: Sequence[Block], falls: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Of the blocks of one size that hold a cell; 0 where nothing is."""
    total, count = np.zeros(occupied.shape), np.zeros(occupied.shape)
    for block, fall in zip(blocks, falls, strict=True):
        total[block.cells] += fall
        count[block.cells] += 1
    return np.divide(total, count, out=np.zeros(occupied.shape), where=occupied & (count > 0))
