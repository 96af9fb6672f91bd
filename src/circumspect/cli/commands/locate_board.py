"""`circumspect locate board`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from circumspect.cli.config_file import ConfigFlag


@dataclass(frozen=True)
class Board:
    """Write pages with the calibration board, or tags for robot and floor, to scale.

    $ circumspect locate board --out print
    $ circumspect locate board --columns 12 --rows 8 --square 0.05 --format pdf
    $ circumspect locate board --tags 0 100 101 102 103 --tag-size 0.16
    """

    out: Path = Path("print")
    """Output folder of the pages. Print them at 100 %, without fitting to the page."""
    columns: int = 9
    """Number of squares in a row of the board."""
    rows: int = 6
    """Number of rows of squares."""
    square: float = 0.03
    """Side of a square [m]."""
    tags: tuple[int, ...] = ()
    """Numbers of 36h11 tags to make instead of the board."""
    tag_size: float = 0.16
    """Side of the black square of a tag [m]."""
    format: Literal["png", "pdf"] = "pdf"
    """File format of the pages."""
    dpi: int = 300
    """Resolution [dots per inch]."""
    json: bool = False
    """Print one JSON line on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Write the pages."""
        pages = self._tags() if self.tags else self._board()
        if self.json:
            print(json.dumps({"pages": [str(page) for page in pages]}))  # noqa: T201
            return 0
        for page in pages:
            print(page)  # noqa: T201
        print("Print at 100 % and measure: a length that is wrong makes every pose wrong.")  # noqa: T201
        return 0

    def _board(self) -> list[Path]:
        from circumspect.localization import CharucoBoard
        from circumspect.localization.printed_page import print_page

        board = CharucoBoard(self.columns, self.rows, self.square)
        path = self.out / f"board-{self.columns}x{self.rows}.{self.format}"
        caption = (
            f"circumspect locate intrinsics --columns {self.columns} --rows {self.rows} "
            f"--square {self.square:g}   ({1e3 * self.square:g} mm a square)"
        )
        print_page(path, board.picture(), board.width, caption, self.dpi)
        return [path]

    def _tags(self) -> list[Path]:
        from circumspect.localization import TagMount, tag_picture
        from circumspect.localization.printed_page import print_page

        pages = []
        for tag_id in self.tags:
            mount = TagMount(tag_id, self.tag_size)
            path = self.out / f"tag-{tag_id}.{self.format}"
            caption = f"36h11 tag {tag_id}: black square {1e3 * mount.size:g} mm, x to the right"
            width = mount.size * 10 / 8
            print_page(path, tag_picture(tag_id), width, caption, self.dpi, arrow=True)
            pages.append(path)
        return pages
