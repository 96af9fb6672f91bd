"""`circumspect grid FILE`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from circumspect.cli.known_faults import blamed_on
from circumspect.errors import InputError


@dataclass(frozen=True)
class Grid:
    """The occupancy grid of a mesh or cloud, as npz and as a picture.

    $ circumspect grid chair.ply --out chair-grid.npz
    """

    file: Annotated[Path, tyro.conf.Positional]
    """OFF, PLY, OBJ, STL, GLB, PCD, XYZ, NPY or NPZ."""
    out: Path | None = None
    """The npz to write; the picture lies beside it. FILE-grid.npz here by default."""
    kind: Literal["cylindrical", "rectangular"] = "cylindrical"
    """Of the grid."""
    cells: tuple[int, int, int] = (32, 32, 32)
    """Along radius, azimuth and height, or along x, y and z."""
    up: Literal["x", "y", "z"] = "z"
    """The axis that points up in the file."""
    samples: int = 32768
    """Points sampled on a mesh."""

    def run(self) -> int:
        """Grid, save and draw."""
        from circumspect.classification import GridRecipe
        from circumspect.evaluation.grid_picture import draw_grid
        from circumspect.geometry import read_cloud
        from circumspect.storage import atomic_path

        out = self.out or Path(f"{self.file.stem}-grid.npz")
        if out.suffix.lower() != ".npz":
            raise InputError(f"--out {out}: a grid is an npz; give a name that ends in .npz")
        recipe = GridRecipe(kind=self.kind, shape=self.cells)
        cloud = read_cloud(self.file, up=self.up, samples=self.samples)
        with blamed_on(self.file):
            grid = recipe.bounds(cloud).hits(recipe.surface(cloud).points_xyz)
        grid.save(out)
        picture = out.with_suffix(".png")
        with atomic_path(picture) as aside:
            draw_grid(grid).savefig(aside, dpi=130, facecolor="white")
        share = 100.0 * grid.occupied.mean()
        print(f"{out}: {int(grid.occupied.sum())} cells occupied ({share:.1f} %)")  # noqa: T201
        print(f"{picture}: the picture")  # noqa: T201
        return 0
