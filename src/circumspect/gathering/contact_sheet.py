"""The clouds of a gathered set in one picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.gathered_set import GatheredScan, read_points
from circumspect.storage import atomic_path

SIDE, MARGIN, HEAD = 110, 120, 18
"""Pixels of a cloud, of the names at the left, and of the top line."""
SHAPE = 1.5
"""Approximate aspect ratio of the sheet."""
MAX_CLOUDS = 600
"""Clouds on a sheet."""
DRAWN_POINTS = 4096
"""Points of a cloud."""
FROM = np.radians([-120.0, 25.0])
"""Azimuth and elevation of the viewpoint."""


def shown_scans(scans: Sequence[GatheredScan], max_clouds: int = MAX_CLOUDS) -> list[GatheredScan]:
    """The scans for a sheet; objects are picked evenly if there are too many.

    Args:
        scans: Of a set.
        max_clouds: Largest number of clouds.
    """
    with_cloud = sorted((scan for scan in scans if "cloud" in scan.files), key=_order)
    objects = list(dict.fromkeys(scan.object for scan in with_cloud))
    columns = {_start(scan) for scan in with_cloud}
    most = max(1, max_clouds // max(1, len(columns)))
    if len(objects) > most:
        picked = np.linspace(0, len(objects) - 1, most).round().astype(int)
        objects = [objects[number] for number in picked]
    chosen = set(objects)
    return [scan for scan in with_cloud if scan.object in chosen]


def draw_contact_sheet(path: Path, folder: Path, scans: Sequence[GatheredScan]) -> None:
    """Draw one object per row and one start per column, all in the frames of their robots.

    With few starts, several blocks of rows are side by side.

    Args:
        path: PNG to write.
        folder: Of the set.
        scans: From `shown_scans`.

    Raises:
        InputError: A cloud is broken.
        OutputError: The picture cannot be written.
    """
    from PIL import Image, ImageDraw

    objects = list(dict.fromkeys(scan.object for scan in scans))
    by_angle = sorted(scans, key=lambda scan: (scan.start_deg is None, scan.start_deg or 0.0))
    columns = list(dict.fromkeys(map(_start, by_angle)))
    width = MARGIN + SIDE * max(1, len(columns))
    blocks = max(1, round(math.sqrt(SHAPE * SIDE * len(objects) / width)))
    rows = max(1, math.ceil(len(objects) / blocks))
    sheet = Image.new("RGB", (width * blocks, HEAD + SIDE * rows), "white")
    pen = ImageDraw.Draw(sheet)
    for left in range(0, width * blocks, width):
        for number, start in enumerate(columns):
            at = left + MARGIN + SIDE * number + 4
            pen.text((at, 3), start or "start unknown", fill="black")
    for number, name in enumerate(objects):
        left, top = width * (number // rows), HEAD + SIDE * (number % rows)
        pen.text((left + 4, top + SIDE // 2), name, fill="black")
        for scan in scans:
            if scan.object == name:
                picture = drawn(read_points(folder / scan.files["cloud"], scan.scan, DRAWN_POINTS))
                at = left + MARGIN + SIDE * columns.index(_start(scan))
                sheet.paste(Image.fromarray(picture), (at, top))
                if scan.quality.get("answer") not in (None, scan.label):
                    pen.text((at + 3, top + 2), str(scan.quality["answer"]), fill=(190, 60, 20))
    with atomic_path(path) as temporary:
        sheet.save(temporary, "PNG")


def _order(scan: GatheredScan) -> tuple[str, str]:
    return scan.label, scan.object


def _start(scan: GatheredScan) -> str:
    return "" if scan.start_deg is None else f"{scan.start_deg:g}°"


def drawn(points_xyz: NDArray[np.float32], side: int = SIDE) -> NDArray[np.uint8]:
    """(side, side, 3) picture of a cloud, seen obliquely from above; near points are darker.

    Args:
        points_xyz: (n, 3), z up.
        side: Pixels.
    """
    azimuth, elevation = FROM
    forward = -np.array([
        np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    ])  # fmt: skip
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    seen = (points_xyz - points_xyz.mean(axis=0)) @ np.column_stack(
        [right, np.cross(forward, right), forward]
    )
    low, high = seen.min(axis=0), seen.max(axis=0)
    scale = (side - 12) / max(float((high - low)[:2].max()), 1e-9)
    pixels = ((seen[:, :2] - (low + high)[:2] / 2) * scale + side / 2).astype(int)
    depth = (seen[:, 2] - low[2]) / max(float(high[2] - low[2]), 1e-9)
    picture = np.full((side, side), 255, np.uint8)
    for number in np.argsort(-depth):
        u, v = pixels[number]
        picture[v : v + 2, u : u + 2] = 40 + int(150 * depth[number])
    return np.repeat(picture[..., None], 3, axis=2)
