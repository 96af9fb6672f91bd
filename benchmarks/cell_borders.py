"""Effect of the position of cell borders on answers: `python -m benchmarks.cell_borders`.

`modelnet10` classifies each piece of procedural furniture several times, at random yaws. Size and
position have errors of fractions of a cell, as in a scan. Dithered grids are compared with grids
that are only rotated.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import RESULTS, progress_report, write_page
from circumspect.classification import GridSpec, OnnxClassifier
from circumspect.classification.shipped import MODELNET10
from circumspect.evaluation.markdown import table
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.grid import CylindricalGrid, Grid, hits_batch

COMMAND = "python -m benchmarks.cell_borders"
EACH = 10
"""Pieces of each category, of variants outside all training sets. The grids of `modelnet10` were
selected on them."""
FIRST_VARIANT = 70_000
TIMES = 12
"""Number of inputs of each piece."""
POINTS = 20_000
ERROR_SIGMA = 0.15
"""Standard deviation of the size and of the centre's coordinates [widths of a ring; a layer is two
widths high]. Scans of one piece from several starts differ by slightly less."""
SCHEMES = ((1, False), (4, False), (4, True), (8, False), (8, True), (16, True))


def main() -> int:
    """Measure and write `cell_borders.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    classifier, report = OnnxClassifier.load(MODELNET10), progress_report()
    assert isinstance(classifier.input_spec, GridSpec)
    rows = []
    for index, (views, dithered) in enumerate(SCHEMES):
        input_spec = classifier.input_spec.with_views(views, dithered)
        scores = [
            np.stack([classifier.scores(inputs) for inputs in _inputs_of_pieces(input_spec, sigma)])
            for sigma in (0.0, ERROR_SIGMA)
        ]
        rows.append(measured(views, dithered, *scores))
        report(index, len(SCHEMES), f"{views} grids{', dithered' if dithered else ''}")
    write_page(
        "cell_borders", "Where cells begin", COMMAND, page_text(rows), {"schemes": rows}, given.out
    )
    return 0


def measured(
    views: int, dithered: bool, turned: NDArray[np.float64], perturbed: NDArray[np.float64]
) -> dict[str, float | bool]:
    """A row of the table.

    Args:
        views: Number of grids of an object.
        dithered: See `GridSpec`.
        turned: (objects, times, classes) scores of pieces that were only rotated.
        perturbed: Scores of pieces with errors of size and position as well.
    """
    labels = perturbed.argmax(axis=2)
    return {
        "views": views,
        "dithered": dithered,
        "turned_spread": float(turned.std(axis=1, ddof=1).mean()),
        "spread": float(perturbed.std(axis=1, ddof=1).mean()),
        "other_label": float((labels != labels[:, :1]).any(axis=1).mean()),
    }


def page_text(rows: list[dict[str, float | bool]]) -> str:
    """The page's text."""
    lines = [
        [
            str(row["views"]), "yes" if row["dithered"] else "no",
            f"{row['turned_spread']:.3f}", f"{row['spread']:.3f}", f"{row['other_label']:.0%}",
        ]
        for row in rows
    ]  # fmt: skip
    return (
        f"{EACH * len(CATEGORIES)} pieces of procedural furniture, each classified {TIMES} times "
        f"at random yaws, and {TIMES} times with errors of size and position as well. Their "
        f"standard deviation is {ERROR_SIGMA:g} of a ring's width, as estimated by a scan. Spread: "
        "standard deviation of a class's score over the inputs, mean over classes and pieces.\n\n"
        + table(
            [
                "grids",
                "dithered",
                "spread, turned",
                "spread, scanned",
                "with other labels, scanned",
            ],
            lines,
        )
    )


def _inputs_of_pieces(input_spec: GridSpec, sigma: float) -> Iterator[NDArray[np.uint8]]:
    """(times, views, *input_shape) inputs of each piece."""
    for index, category in enumerate(CATEGORIES):
        for number in range(EACH):
            cloud = make_furniture(category, FIRST_VARIANT + number).sampled(POINTS, 0)
            # The same errors for every input specification.
            rng = np.random.default_rng([index, number])
            views = [
                view
                for _ in range(TIMES)
                for view in input_spec.all_bounds(_perturbed(input_spec.bounds(cloud), sigma, rng))
            ]
            grids = hits_batch(views, [cloud] * len(views))
            yield grids.reshape(TIMES, input_spec.azimuth_views, *input_spec.input_shape)


def _perturbed(bounds: Grid, sigma: float, rng: np.random.Generator) -> CylindricalGrid:
    """Bounds at a random yaw with random errors; `sigma` in widths of a ring."""
    assert isinstance(bounds, CylindricalGrid)
    cell = bounds.radius / bounds.shape[0]
    radius = bounds.radius + rng.normal(0.0, sigma) * cell
    centre = np.asarray(bounds.centre_xyz) + rng.normal(0.0, sigma, 3) * cell
    turned = bounds.rotated(float(rng.uniform(0, bounds.shape[1])))
    return replace(turned, radius=radius, half_height=radius, centre_xyz=tuple(centre))


if __name__ == "__main__":
    sys.exit(main())
