"""Printed pages with boards and tags, to scale."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.storage import atomic_path

if TYPE_CHECKING:
    from PIL.Image import Image

A4 = (0.210, 0.297)
"""[m]."""
MARGIN = 0.005
"""White margin that printers leave [m]."""
CAPTION = 0.007
"""Height of the caption [m]."""
INCH = 0.0254
FORMATS = (".png", ".pdf")


def print_page(
    path: str | os.PathLike[str],
    picture: NDArray[np.uint8],
    width: float,
    caption: str,
    dpi: int = 300,
    arrow: bool = False,
) -> None:
    """Write a picture on a page of A4, or larger if necessary.

    Args:
        path: A PNG with its resolution, or a PDF; to be printed at 100 %.
        picture: Grey picture with square pixels.
        width: Width of the picture on paper [m].
        caption: Caption below the picture.
        dpi: Dots per inch.
        arrow: Whether to draw an arrow to the right, the tag's x axis.

    Raises:
        InputError: Unsupported format, or too large a page.
        OutputError: The file cannot be written.
    """
    if Path(path).suffix.lower() not in FORMATS:
        raise InputError(f"{path}: pages are written as {' or '.join(FORMATS)}")
    if not 50 <= dpi <= 1200:
        raise InputError(f"pages have 50 to 1200 dots per inch, not {dpi}")
    page = _page(picture, width, caption, dpi, arrow)
    with atomic_path(path) as aside:
        page.save(aside, dpi=(dpi, dpi), resolution=float(dpi))


def _page(picture: NDArray[np.uint8], width: float, caption: str, dpi: int, arrow: bool) -> Image:
    from PIL import Image, ImageDraw, ImageFont

    rows, columns = picture.shape
    height = width * rows / columns
    needed = (width + 2 * MARGIN, height + 2 * MARGIN + CAPTION)
    sheets = [A4, A4[::-1]]
    sheet = next((s for s in sheets if s[0] >= needed[0] and s[1] >= needed[1]), needed)
    dots = dpi / INCH
    size = (round(sheet[0] * dots), round(sheet[1] * dots))
    if size[0] * size[1] > 2e8:
        raise InputError(f"a page of {sheet[0]:.2f} x {sheet[1]:.2f} m at {dpi} dpi is too large")
    page = Image.new("L", size, 255)
    inner = (round(width * dots), round(height * dots))
    shown = Image.fromarray(picture).resize(inner, Image.Resampling.NEAREST)
    left, top = (size[0] - inner[0]) // 2, (size[1] - inner[1] - round(CAPTION * dots)) // 2
    page.paste(shown, (left, top))
    draw = ImageDraw.Draw(page)
    font = ImageFont.load_default(size=0.0032 * dots)
    below = top + inner[1] + 0.002 * dots
    draw.text((left, below), caption, fill=90, font=font)
    if arrow:
        _draw_arrow(draw, left + inner[0] - 0.03 * dots, below + 0.002 * dots, 0.028 * dots, dots)
    return page


def _draw_arrow(draw: object, x: float, y: float, length: float, dots: float) -> None:
    """Draw an arrow to the right, with its name."""
    from PIL.ImageDraw import ImageDraw

    assert isinstance(draw, ImageDraw)
    head, thick = 0.0015 * dots, max(1, round(0.0004 * dots))
    draw.line([(x, y), (x + length, y)], fill=90, width=thick)
    tip = (x + length, y)
    draw.polygon([tip, (tip[0] - 2 * head, y - head), (tip[0] - 2 * head, y + head)], fill=90)
