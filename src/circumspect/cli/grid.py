"""`circumspect grid FILE`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from circumspect.cli.object_cloud import object_cloud
from circumspect.cli.say import say
from circumspect.cli.unit import metres_per_unit, unit_shown
from circumspect.errors import InputError, MissingExtraError, blamed_on, printable

if TYPE_CHECKING:
    from circumspect.geometry import PointCloud
    from circumspect.grid import OccupancyGrid


@dataclass(frozen=True)
class Grid:
    """The occupancy grid of a mesh or cloud, as npz and as a picture.

    $ circumspect grid chair.ply --out chair-grid.npz
    $ circumspect grid chair.ply --turn 0 45 90 100
    """

    file: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """OFF, PLY, OBJ, STL, GLB, PCD, XYZ, CSV, NPY or NPZ."""
    out: Path | None = None
    """The npz to write; the picture lies beside it. FILE-grid.npz here by default."""
    kind: Literal["cylindrical", "rectangular"] = "cylindrical"
    """Of the grid."""
    cells: tuple[int, int, int] = (32, 32, 32)
    """Along radius, azimuth and height, or along x, y and z."""
    up: Literal["x", "y", "z"] | None = None
    """The axis that points up in the file; by default y for glTF/GLB, what the file says for USD,
    and z for all others."""
    reader: Annotated[str | None, tyro.conf.arg(metavar="NAME|MODULE:NAME")] = None
    """A reader of your own, as of `circumspect classify`."""
    margin: float = 1.1
    """The grid is this many times as large as the smallest one that holds the object. The shipped
    classifiers expect 1.1; the paper has 1."""
    turn: tuple[float, ...] = ()
    """Draw both kinds of grid of the object turned by these angles [degrees], too: cylindrical
    ones shift, rectangular ones change."""
    samples: int = 32768
    """Points sampled on a mesh."""

    def run(self) -> int:
        """Grid, save and draw."""
        from circumspect.classification import GridRecipe
        from circumspect.grid.grid_file import holds_grid

        out = self.out or Path(f"{self.file.stem}-grid.npz")
        if out.suffix.lower() != ".npz":
            raise InputError(f"--out {out}: a grid is an npz; give a name that ends in .npz")
        if not all(abs(turn) < 1e6 for turn in self.turn):
            raise InputError(f"--turn {' '.join(f'{t:g}' for t in self.turn)}: give degrees")
        if self.reader is None and holds_grid(self.file):
            raise InputError(f"{self.file}: is a grid already; give what it was made of")
        recipe = GridRecipe(kind=self.kind, shape=self.cells, margin=self.margin)
        cloud = object_cloud(self.file, self.up, self.samples, None, self.reader)
        with blamed_on(self.file):
            grid = recipe.bounds(cloud).hits(recipe.surface(cloud).points_xyz)
        grid.save(out)
        share = 100.0 * grid.occupied.mean()
        told = printable(str(out))
        print(f"{told}: {int(grid.occupied.sum())} cells occupied ({share:.1f} %)")  # noqa: T201
        self._draw(grid, out.with_suffix(".png"))
        if self.turn:
            self._draw_turning(cloud, out.with_name(f"{out.stem}-turned.png"))
        return 0

    def _draw_turning(self, cloud: PointCloud, picture: Path) -> None:
        from circumspect.evaluation.figures import save_figure
        from circumspect.evaluation.turning_picture import draw_turning, turned_grids

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
