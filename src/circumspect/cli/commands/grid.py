"""`circumspect grid FILE`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from circumspect.cli.object_cloud import metres_per_unit, object_cloud, unit_shown
from circumspect.cli.say import say
from circumspect.errors import InputError, MissingExtraError, naming_file, printable

if TYPE_CHECKING:
    from circumspect.geometry import PointCloud
    from circumspect.grid import OccupancyGrid


@dataclass(frozen=True)
class Grid:
    """Compute the occupancy grid of a mesh or cloud, as an npz file and a picture.

    $ circumspect grid chair.ply --out chair-grid.npz
    $ circumspect grid chair.ply --turn 0 45 90 100
    """

    file: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """OFF, PLY, OBJ, STL, GLB, PCD, XYZ, CSV, NPY or NPZ."""
    out: Path | None = None
    """The npz file to write, with the picture beside it. Default: FILE-grid.npz in the current
    folder."""
    kind: Literal["cylindrical", "rectangular"] = "cylindrical"
    """Kind of the grid."""
    cells: tuple[int, int, int] = (32, 32, 32)
    """Number of cells along radius, azimuth and height, or along x, y and z."""
    up: Literal["x", "y", "z"] | None = None
    """Axis that points up in the file. Default: y for glTF/GLB, the axis stated in the file for
    USD, z for all others."""
    reader: Annotated[str | None, tyro.conf.arg(metavar="NAME|MODULE:NAME")] = None
    """Your own reader for the file, see `circumspect classify`."""
    margin: float = 1.1
    """Size of the grid relative to the smallest grid that holds the object. The shipped classifiers
    expect 1.1; the paper uses 1."""
    turn: tuple[float, ...] = ()
    """Also draw both kinds of grid of the object turned by these angles [degrees]: cylindrical
    grids shift, rectangular grids change."""
    samples: int = 32768
    """Number of points sampled on a mesh."""

    def run(self) -> int:
        """Compute, save and draw the grid."""
        from circumspect.classification import GridSpec
        from circumspect.grid.grid_file import holds_grid

        out = self.out or Path(f"{self.file.stem}-grid.npz")
        if out.suffix.lower() != ".npz":
            raise InputError(f"--out {out}: a grid is an npz; give a name that ends in .npz")
        if not all(abs(turn) < 1e6 for turn in self.turn):
            raise InputError(f"--turn {' '.join(f'{t:g}' for t in self.turn)}: give degrees")
        if self.reader is None and holds_grid(self.file):
            raise InputError(f"{self.file}: is a grid already; give what it was made of")
        input_spec = GridSpec(kind=self.kind, shape=self.cells, margin=self.margin)
        cloud = object_cloud(self.file, self.up, self.samples, None, self.reader)
        with naming_file(self.file):
            grid = input_spec.bounds(cloud).hits(input_spec.surface(cloud).points_xyz)
        grid.save(out)
        share = 100.0 * grid.occupied.mean()
        place = printable(str(out))
        print(f"{place}: {int(grid.occupied.sum())} cells occupied ({share:.1f} %)")  # noqa: T201
        self._draw(grid, out.with_suffix(".png"))
        if self.turn:
            self._draw_turning(cloud, out.with_name(f"{out.stem}-turned.png"))
        return 0

    def _draw_turning(self, cloud: PointCloud, picture: Path) -> None:
        from circumspect.evaluation.figures import save_figure
        from circumspect.evaluation.grid_picture import draw_turning, turned_grids

        grids = turned_grids(cloud, self.cells, self.turn, self.margin)
        save_figure(draw_turning(grids, self.turn), picture)
        print(f"{printable(str(picture))}: both kinds of grid, turned")  # noqa: T201

    def _draw(self, grid: OccupancyGrid, picture: Path) -> None:
        from circumspect.evaluation.grid_picture import draw_grid
        from circumspect.storage import atomic_path

        try:
            figure = draw_grid(grid, unit_shown(metres_per_unit(self.file, None)))
        except MissingExtraError as error:
            say(f"no picture: {error}")
            return
        with atomic_path(picture) as aside:
            figure.savefig(aside, dpi=130, facecolor="white")
        print(f"{printable(str(picture))}: the picture")  # noqa: T201
