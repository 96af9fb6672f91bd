"""Many pieces in one picture.

python -m circumspect.furniture.contact_sheet OUT.png
python -m circumspect.furniture.contact_sheet OUT.png other-things
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence

import numpy as np

from circumspect.furniture.catalogue import CATEGORIES, make_furniture
from circumspect.furniture.other_things import OTHER_THINGS, make_other_thing
from circumspect.furniture.shading import shaded
from circumspect.geometry import TriangleMesh
from circumspect.storage import atomic_path

_MARGIN = 110
"""Pixels at the left for the names of the categories."""


def draw_contact_sheet(
    path: str | os.PathLike[str],
    columns: int = 8,
    first_seed: int = 0,
    pixels: int = 150,
    kinds: Sequence[str] = CATEGORIES,
    make: Callable[[str, int], TriangleMesh] = make_furniture,
) -> None:
    """Draw some pieces of each category, one category a row.

    Args:
        path: PNG to write.
        columns: Pieces a category, of the seeds from `first_seed` on.
        first_seed: Seed of the leftmost column.
        pixels: Side of the picture of one piece.
        kinds: The categories.
        make: Makes a piece of a category from a seed.

    Raises:
        OutputError: The file cannot be written.
    """
    from PIL import Image, ImageDraw

    sheet = np.ones((len(kinds) * pixels, _MARGIN + columns * pixels, 3))
    for row, category in enumerate(kinds):
        for column in range(columns):
            top, left = row * pixels, _MARGIN + column * pixels
            piece = make(category, first_seed + column)
            sheet[top : top + pixels, left : left + pixels] = shaded(piece, pixels)
    image = Image.fromarray(np.rint(sheet * 255).astype(np.uint8))
    pen = ImageDraw.Draw(image)
    for row, category in enumerate(kinds):
        pen.text((8, (row + 0.5) * pixels - 9), category, fill=(30, 30, 30), font_size=16)
    with atomic_path(path) as temporary:
        image.save(temporary, format="PNG")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["other-things"]):
        sys.exit(f"give one file to write: {__doc__}")
    if len(sys.argv) == 2:
        draw_contact_sheet(sys.argv[1])
    else:
        draw_contact_sheet(sys.argv[1], kinds=tuple(OTHER_THINGS), make=make_other_thing)
