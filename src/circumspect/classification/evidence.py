"""Evidence of cells for a class: blocks of cells are emptied, and the grid is classified again."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.classification.grid_spec import GridSpec
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.prediction import Prediction
from circumspect.errors import InputError
from circumspect.geometry import PointCloud
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid
from circumspect.grid.grid import FREE, OCCUPIED, UNKNOWN
from circumspect.storage import atomic_open

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EDGES = (0.5, 0.25)
"""Edges of the blocks [grid radii]: the size of parts of an object and of their details."""
BATCH = 32


@dataclass(frozen=True)
class Block:
    """A block of cells: rows along each axis and all cells in which they meet.

    Attributes:
        rows: Indices along each of the three axes.
    """

    rows: tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]

    @property
    def cells(self) -> tuple[NDArray[np.intp], ...]:
        """Index of the block in an array of the grid's shape."""
        return np.ix_(*self.rows)


def occupied_blocks(grid: OccupancyGrid, edge: float) -> list[Block]:
    """The blocks of a grid that hold something.

    In a cylinder there is a block at every azimuth cell, wrapped, so that turning the object by
    whole cells turns its blocks. Near the axis, where sectors are narrow, blocks span more of them.

    Args:
        grid: Occupied or not.
        edge: Of a block, as a share of the grid's radius or half width: above 0, at most 2.

    Raises:
        InputError: An edge out of range.
    """
    if not 0.0 < edge <= 2.0:
        raise InputError(f"the edge of a block must lie in 0 … 2 grid radii, not {edge!r}")
    occupied = grid.occupied
    bounds = grid.grid
    if isinstance(bounds, CylindricalGrid):
        blocks = _in_cylinder(bounds, edge)
    elif isinstance(bounds, RectangularGrid):
        blocks = _in_box(bounds, edge)
    else:
        raise InputError(f"no blocks are known for a grid of type {type(bounds).__name__}")
    return [block for block in blocks if occupied[block.cells].any()]


def _in_cylinder(bounds: CylindricalGrid, edge: float) -> Iterator[Block]:
    radii, azimuths, heights = bounds.shape
    deep = _cells(edge * radii)
    high = _cells(edge * bounds.radius * heights / (2.0 * bounds.half_height))
    for rings in _parts(radii, deep):
        middle = (rings[0] + rings[-1] + 1) / (2.0 * radii)
        wide = min(azimuths, _cells(edge * azimuths / (2.0 * np.pi * middle)))
        for layers in _parts(heights, high):
            for first in range(azimuths if wide < azimuths else 1):
                yield Block((rings, (first + np.arange(wide)) % azimuths, layers))


def _in_box(bounds: RectangularGrid, edge: float) -> Iterator[Block]:
    across, along, up = (_parts(count, _cells(edge * count / 2.0)) for count in bounds.shape)
    for x in across:
        for y in along:
            for z in up:
                yield Block((x, y, z))


def _cells(length: float) -> int:
    return max(1, round(length))


def _parts(count: int, size: int) -> list[NDArray[np.intp]]:
    return [np.arange(first, min(first + size, count)) for first in range(0, count, size)]


@dataclass(frozen=True, eq=False)
class CellEvidence(ReadOnlyArrays):
    """How much each occupied cell supports a class.

    Attributes:
        grid: The input.
        prediction: The answer to it.
        label: The class that the evidence is for or against.
        log_odds: ln(p / (1 - p)) of that class, all cells in place.
        cells: float32 of the grid's shape, 0 where nothing is: by how much the log-odds fall when
            the cell's neighbourhood is emptied. Above 0 the cells speak for the class, below
            against it.
        grid_count: Number of changed grids that were classified.
    """

    grid: OccupancyGrid
    prediction: Prediction
    label: str
    log_odds: float
    cells: NDArray[np.float32]
    grid_count: int

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

    @property
    def half_share(self) -> float:
        """The smallest share of the occupied cells with half of what speaks for the class."""
        positive = np.sort(self.cells[self.cells > 0])[::-1].astype(np.float64)
        if not positive.size:
            return 0.0
        held = np.cumsum(positive)
        needed = int(np.searchsorted(held, held[-1] / 2)) + 1
        return needed / int(self.grid.occupied.sum())

    def to_dict(self) -> dict[str, Any]:
        """The strongest evidence, and how many cells hold half of it, in JSON types."""
        return {
            "most": round(float(self.cells.max()), 4),
            "least": round(float(self.cells.min()), 4),
            "half_of_it_in": round(self.half_share, 4),
            "grids_asked": self.grid_count,
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as npz: `evidence` and `states` of the cells, the grid's bounds, the answer.

        Raises:
            OutputError: The file cannot be written.
        """
        bounds: dict[str, Any] = {
            name: np.asarray(value)
            for name, value in vars(self.grid.grid).items()
            if name != "shape"
        }
        answer = self.prediction.probabilities
        with atomic_open(path, "wb") as stream:
            np.savez_compressed(
                stream,
                evidence=self.cells,
                states=self.grid.states,
                label=np.array([self.label]),
                log_odds=np.array([self.log_odds]),
                classes=np.array(list(answer)),
                probabilities=np.array(list(answer.values())),
                **bounds,
            )

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the grid unrolled: red cells speak for the class, blue ones against it.

        Args:
            axes: Where to draw; None for a new figure.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        from circumspect.classification.evidence_plot import draw_evidence_grid
        from circumspect.figure_canvas import axes_or_new

        axes = axes_or_new(axes)
        draw_evidence_grid(axes, self.cells, self.grid)
        axes.set_title(f"red: for {self.label.replace('_', ' ')}, blue: against it")
        return axes


def cell_evidence(
    classifier: OnnxClassifier,
    grid: OccupancyGrid,
    label: str | None = None,
    edges: Sequence[float] = EDGES,
    progress: Callable[[int, int], None] | None = None,
    *,
    metric: bool = False,
) -> CellEvidence:
    """Classify a grid repeatedly, each time with another block of cells emptied.

    The evidence of a cell is the mean fall of the log-odds over the blocks that hold it, then the
    mean over the sizes of blocks.

    Args:
        classifier: Of grids.
        grid: An object as the classifier's input specification grids it.
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
    after = _log_odds_of(shown, changed, column, progress)
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
    """Classifies variants of a grid with emptied cells.

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
        input_spec = classifier.input_spec
        assert isinstance(input_spec, GridSpec)  # Others accept no grid.
        emptied, filled = np.zeros(grid.states.shape, np.uint8), 1
        if input_spec.visibility:
            # Emptied cells that rays crossed are free; in a cloud without rays they are unknown.
            nothing = FREE if grid.free.any() else UNKNOWN
            emptied, filled = np.where(grid.occupied, np.uint8(nothing), grid.states), OCCUPIED
        bounds = grid.grid if metric else None
        return cls(
            classifier, emptied, filled, input_spec.context(input_spec.input_of(grid)[None], bounds)
        )

    def log_odds(self, occupied: NDArray[np.bool_] | NDArray[np.uint8]) -> NDArray[np.float64]:
        """(n, c) log-odds for (n, *shape) grids with only these cells."""
        inputs = np.where(occupied, np.uint8(self.filled), self.emptied)[:, None, None]
        contexts = None
        if self.context is not None:
            contexts = np.repeat(self.context[None], len(inputs), axis=0)
        return log_odds(self.classifier.scores(inputs, contexts))


def _log_odds_of(
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
    """(shape) mean fall over the blocks of one size that hold each cell; 0 for empty cells."""
    total, count = np.zeros(occupied.shape), np.zeros(occupied.shape)
    for block, fall in zip(blocks, falls, strict=True):
        total[block.cells] += fall
        count[block.cells] += 1
    return np.divide(total, count, out=np.zeros(occupied.shape), where=occupied & (count > 0))
