"""Which cells carry a decision: cells are emptied, and the answer is asked anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.classification.grid_recipe import GridRecipe
from circumspect.classification.occlusion_blocks import Block, occupied_blocks
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.prediction import Prediction
from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.grid import OccupancyGrid
from circumspect.grid.occupancy_grid import FREE, OCCUPIED, UNKNOWN

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
    *,
    metric: bool = False,
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
        metric: The grid's bounds are in metres; without it the scale counts as unknown. The size
            that the network is shown stays that of the whole object while cells are emptied.

    Raises:
        InputError: A grid of another kind or shape than the classifier takes, an empty one, an
            unknown label, or an edge out of range.
    """
    prediction = classifier.classify_grid(grid, metric=metric)
    column = _column(classifier, prediction.label if label is None else label)
    occupied = grid.occupied
    if not edges:
        raise InputError("give at least one size of blocks")
    blocks = [occupied_blocks(grid, edge) for edge in edges]
    changed, which = _distinct(occupied, [block for sized in blocks for block in sized])
    shown = _ShownGrid.of(classifier, grid, metric)
    before = shown.log_odds(occupied[None])[0, column]
    after = _asked(shown, changed, column, progress)
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
    """ln(p / (1 - p)) of each class: unlike p, it does not saturate at probabilities near 1.

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


@dataclass(frozen=True, eq=False)
class _ShownGrid:
    """Shows a classifier a grid of which some cells were emptied.

    Attributes:
        classifier: Of grids.
        emptied: uint8 of the grid's shape: the input where every occupied cell is emptied.
        filled: The input's value for an occupied cell.
        context: (6,) of the whole object, or None where the network takes none.
    """

    classifier: OnnxClassifier
    emptied: NDArray[np.uint8]
    filled: int
    context: NDArray[np.float32] | None

    @classmethod
    def of(cls, classifier: OnnxClassifier, grid: OccupancyGrid, metric: bool) -> _ShownGrid:
        recipe = classifier.recipe
        assert isinstance(recipe, GridRecipe)  # Others accept no grid.
        emptied, filled = np.zeros(grid.states.shape, np.uint8), 1
        if recipe.visibility:
            # What was seen by rays is seen to be empty; of a mere cloud nobody knows.
            nothing = FREE if grid.free.any() else UNKNOWN
            emptied, filled = np.where(grid.occupied, np.uint8(nothing), grid.states), OCCUPIED
        bounds = grid.grid if metric else None
        return cls(classifier, emptied, filled, recipe.context(recipe.input_of(grid)[None], bounds))

    def log_odds(self, occupied: NDArray[np.bool_] | NDArray[np.uint8]) -> NDArray[np.float64]:
        """(n, c) of (n, *shape) grids of which these cells are left."""
        inputs = np.where(occupied, np.uint8(self.filled), self.emptied)[:, None, None]
        contexts = None
        if self.context is not None:
            contexts = np.repeat(self.context[None], len(inputs), axis=0)
        return log_odds(self.classifier.scores(inputs, contexts))


def _asked(
    shown: _ShownGrid,
    changed: NDArray[np.uint8],
    column: int,
    progress: Callable[[int, int], None] | None,
) -> NDArray[np.float64]:
    """(n,) log-odds of a class in n packed grids."""
    found = np.empty(len(changed))
    shape = shown.emptied.shape
    cells = int(np.prod(shape))
    for start in range(0, len(changed), BATCH):
        part = slice(start, start + BATCH)
        grids = np.unpackbits(changed[part], axis=1, count=cells).reshape(-1, *shape)
        found[part] = shown.log_odds(grids)[:, column]
        if progress is not None:
            progress(min(start + BATCH, len(changed)), len(changed))
    return found


def _mean_fall(
    occupied: NDArray[np.bool_], blocks: Sequence[Block], falls: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Of the blocks of one size that hold a cell; 0 where nothing is."""
    total, count = np.zeros(occupied.shape), np.zeros(occupied.shape)
    for block, fall in zip(blocks, falls, strict=True):
        total[block.cells] += fall
        count[block.cells] += 1
    return np.divide(total, count, out=np.zeros(occupied.shape), where=occupied & (count > 0))
