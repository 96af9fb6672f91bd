"""How answers depend on where an object's cells begin: `python -m benchmarks.cell_borders`.

Procedural furniture, each piece several times: turned anyhow, its size and place wrong by
fractions of a cell, as a scan estimates them. Grids that are dithered are compared with grids that
are only turned, by `modelnet10`.
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
"""Pieces of a category, of variants that nothing was trained on; by them it was chosen how the
classifier `modelnet10` is asked."""
FIRST_VARIANT = 70_000
TIMES = 12
"""How often each is shown."""
POINTS = 20_000
WRONG = 0.15
"""Standard deviation of the size and of the centre's coordinates [widths of a ring, of which a
layer's height is two]: somewhat more than scans of one piece from several starts differ by."""
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
            np.stack([classifier.scores(shown) for shown in _shown_often(input_spec, wrong)])
            for wrong in (0.0, WRONG)
        ]
        rows.append(measured(views, dithered, *scores))
        report(index, len(SCHEMES), f"{views} grids{', dithered' if dithered else ''}")
    write_page(
        "cell_borders", "Where cells begin", COMMAND, page_text(rows), {"schemes": rows}, given.out
    )
    return 0


def measured(
    views: int, dithered: bool, turned: NDArray[np.float64], wrong: NDArray[np.float64]
) -> dict[str, float | bool]:
    """A row of the table.

    Args:
        views: Grids an object.
        dithered: See `GridSpec`.
        turned: (objects, times, classes) scores of pieces that were only turned.
        wrong: Of those whose size and place were wrong as well.
    """
    labels = wrong.argmax(axis=2)
    return {
        "views": views,
        "dithered": dithered,
        "turned_spread": float(turned.std(axis=1, ddof=1).mean()),
        "spread": float(wrong.std(axis=1, ddof=1).mean()),
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
        f"{EACH * len(CATEGORIES)} pieces of procedural furniture, each shown {TIMES} times turned "
        f"anyhow, and as often with size and place off by {WRONG:g} of a ring's width (standard "
        "deviation) as well, as estimated by a scan. Spread: standard deviation of a class's score "
        "over the times, mean over classes and pieces.\n\n"
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


def _shown_often(input_spec: GridSpec, wrong: float) -> Iterator[NDArray[np.uint8]]:
    """(times, views, *input_shape) of each piece."""
    for index, category in enumerate(CATEGORIES):
        for number in range(EACH):
            cloud = make_furniture(category, FIRST_VARIANT + number).sampled(POINTS, 0)
            # The same errors for every input specification.
            rng = np.random.default_rng([index, number])
            views = [
                view
                for _ in range(TIMES)
                for view in input_spec.all_bounds(_misplaced(input_spec.bounds(cloud), wrong, rng))
            ]
            grids = hits_batch(views, [cloud] * len(views))
            yield grids.reshape(TIMES, input_spec.azimuth_views, *input_spec.input_shape)


def _misplaced(bounds: Grid, wrong: float, rng: np.random.Generator) -> CylindricalGrid:
    """Bounds turned anyhow, wrong by so many widths of a ring."""
    assert isinstance(bounds, CylindricalGrid)
    cell = bounds.radius / bounds.shape[0]
    radius = bounds.radius + rng.normal(0.0, wrong) * cell
    centre = np.asarray(bounds.centre_xyz) + rng.normal(0.0, wrong, 3) * cell
    turned = bounds.rotated(float(rng.uniform(0, bounds.shape[1])))
    return replace(turned, radius=radius, half_height=radius, centre_xyz=tuple(centre))


if __name__ == "__main__":
    sys.exit(main())
