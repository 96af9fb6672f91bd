"""`circumspect locate board`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Literal


@dataclass(frozen=True)
class Board:
    """Print the calibration board, and tags for robot and floor, to scale.

    $ circumspect locate board --out print
    $ circumspect locate board --columns 12 --rows 8 --square 0.05 --format pdf
    $ circumspect locate board --tags 0 100 101 102 103 --tag-size 0.16
    """

    out: Path = Path("print")
    """Folder of the pages; print them at 100 %, without fitting to the page."""
    columns: int = 9
    """Squares of the board along a row."""
    rows: int = 6
    """Rows of squares."""
    square: float = 0.03
    """Side of a square [m]."""
    tags: tuple[int, ...] = ()
    """Numbers of 36h11 tags; with any, these are printed instead of the board."""
    tag_size: float = 0.16
    """Side of a tag's black square [m]."""
    format: Literal["png", "pdf"] = "pdf"
    """Of the pages."""
    dpi: int = 300
    """Dots per inch."""
    json: bool = False
    """One JSON line on standard output and nothing else there."""

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
