"""Accuracy of surfaces reconstructed from 1,024 points: `python -m benchmarks.point_surfaces`.

Procedural furniture is sampled like the point packs, reconstructed, and compared with the original
in depth images from eight sides.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.report import RESULTS, progress_report, write_page
from circumspect.datasets.farthest_points import evenly_sampled
from circumspect.evaluation.figures import save_figure
from circumspect.evaluation.markdown import table
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.simulation import Orbit, RayCaster, Scene, Surface, surface_from_points

COMMAND = "python -m benchmarks.point_surfaces"
VARIANTS = 3
DRAWN = ("chair", "sofa", "table")
CAMERA = PinholeCamera(160, 120, 142.6, 142.6, 79.5, 59.5)
SURFACE_GAP_M = 0.05
"""Depths that differ by more lie on different surfaces [m]."""


def main() -> int:
    """Measure and write `point_surfaces.md` with its picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    rows, report = {}, progress_report()
    for index, category in enumerate(CATEGORIES):
        report(index, len(CATEGORIES), category)
        found = [differences(*depths_of_both(category, seed)) for seed in range(VARIANTS)]
        rows[category] = np.mean(found, axis=0).tolist()
    save_figure(drawn(), given.out / "point_surfaces.png")
    write_page(
        "point_surfaces", "Surfaces made of 1,024 points", COMMAND, page_text(rows), {"rows": rows},
        given.out,
    )  # fmt: skip
    return 0


def depths_of_both(category: str, seed: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Two (8, height, width) depths [m], of a piece and of its reconstruction from points."""
    true = make_furniture(category, seed)
    points = evenly_sampled(true, seed).astype(np.float64)
    rebuilt = surface_from_points(points, category)
    # Scaled to the size of the true piece instead of that of the category.
    scale = np.ptp(true.vertices_xyz, axis=0).max() / np.ptp(rebuilt.vertices_xyz, axis=0).max()
    rebuilt = TriangleMesh(rebuilt.vertices_xyz * scale, rebuilt.faces)
    return depths(true, true), depths(rebuilt, true)


def differences(true: NDArray[np.floating], rebuilt: NDArray[np.floating]) -> list[float]:
    """How two depths differ.

    Args:
        true: (…) depths of the object [m], infinite without a surface.
        rebuilt: (…) depths of its reconstruction [m].

    Returns:
        Three shares of the object's pixels: rays that pass through the reconstruction, those of
        them that miss it, and those that hit it too early. Then median and 90th percentile of the
        depth errors [mm].
    """
    hit, again = np.isfinite(true), np.isfinite(rebuilt)
    both = hit & again
    further = np.subtract(rebuilt, true, where=both, out=np.zeros(true.shape))
    missed = (hit & ~again).sum()
    through = missed + (further > SURFACE_GAP_M).sum()
    before = (again & ~hit).sum() + (further < -SURFACE_GAP_M).sum()
    shares = [float(count / hit.sum()) for count in (through, missed, before)]
    median, most = np.percentile(1000 * np.abs(further[both]), [50, 90])
    return [*shares, float(median), float(most)]


def depths(mesh: TriangleMesh, circled: TriangleMesh) -> NDArray[np.float32]:
    """(8, height, width) depths of a mesh without a floor, from the orbit round another mesh."""
    orbit = Orbit.around(circled, PinholeCamera.xtion())
    caster = RayCaster(Scene((Surface("object", mesh),)))
    stations = (orbit.station(k * np.pi / 4 + 0.2) for k in range(8))
    return np.stack([caster.view(CAMERA, station.T_map_camera).depth for station in stations])


def drawn() -> Figure:
    """Depth images of some pieces beside those of their rebuilt surfaces."""
    figure = Figure(figsize=(2.9 * len(DRAWN), 4.6), layout="constrained")
    panels = figure.subplots(2, len(DRAWN))
    for column, category in enumerate(DRAWN):
        true, rebuilt = (
            np.where(np.isfinite(d[0]), d[0], np.nan) for d in depths_of_both(category, 0)
        )
        span = {"vmin": np.nanmin(true), "vmax": np.nanmax(true), "cmap": "viridis"}
        images = [
            panel.imshow(depth, **span)
            for panel, depth in zip(panels[:, column], (true, rebuilt), strict=True)
        ]
        figure.colorbar(images[0], ax=panels[:, column], location="bottom", label="depth [m]")
        panels[0, column].set_title(category, fontsize=10)
        panels[1, column].set_title(f"{category}, rebuilt", fontsize=10)
    for panel in panels.flat:
        panel.set_axis_off()
    return figure


def page_text(rows: dict[str, list[float]]) -> str:
    """The page's text."""
    lines = [
        [name.replace("_", " "), *(f"{share:.1%}" for share in row[:3]),
         *(f"{error:.1f}" for error in row[3:])]
        for name, row in {**rows, "mean": np.mean(list(rows.values()), axis=0)}.items()
    ]  # fmt: skip
    head = ["", "through", "of these missed", "before", "median [mm]", "90 % [mm]"]
    return (
        f"Procedural furniture, {VARIANTS} pieces per category, sampled to 1,024 spread points "
        "like ModelNet10's packs, reconstructed, and compared with the original in depth images "
        "from eight sides. Columns, as shares of the object's pixels: through, the reconstruction "
        f"is more than {100 * SURFACE_GAP_M:g} cm behind the object or missed; before, it is that "
        "far in front of the object or beside it. The errors are those of the pixels on both.\n\n"
        + table(head, lines)
        + "\n\n![Depth images of furniture and of its rebuilt surfaces](point_surfaces.png)"
    )


if __name__ == "__main__":
    sys.exit(main())
