"""The diagram of the data flow: `python docs/data_flow.py` writes docs/data-flow.svg."""

from __future__ import annotations

import argparse
from html import escape
from pathlib import Path

from circumspect.storage import atomic_open

SIZE = (640, 520)
BOX = (180, 76)
"""Of the picture and of a box [px]."""
BOXES = {
    "source": (20, 30, "Frames", "RgbdFrame, Odometry", "robot, recording, ros"),
    "track": (230, 30, "1 Track", "PoseEstimate", "registration, tracking"),
    "graph": (440, 30, "Close loops", "corrected keyframes", "pose_graph"),
    "segment": (230, 160, "2 Segment", "mask of the object", "sensing"),
    "fuse": (440, 160, "3 Fuse", "ObjectModel", "reconstruction"),
    "grid": (440, 290, "4 Grid", "OccupancyGrid", "grid"),
    "classify": (230, 290, "5 Classify", "Prediction", "classification"),
    "plan": (20, 290, "6 Plan", "NextView or Finished", "planning, exploration"),
    "run": (230, 415, "Observe", "run folder, page, topics", "runs, viewer, ros"),
}
"""Left, top, title, what comes out, and the packages."""
ARROWS = (
    ((200, 68), (230, 68)),
    ((410, 58), (440, 58)),
    ((440, 82), (410, 82)),
    ((320, 106), (320, 160)),
    ((410, 198), (440, 198)),
    ((530, 106), (530, 160)),
    ((530, 236), (530, 290)),
    ((440, 328), (410, 328)),
    ((230, 328), (200, 328)),
    ((110, 290), (110, 106)),
    ((320, 366), (320, 415)),
)
NOTES = ((119, 200, "drive"), (540, 137, "submaps"))


def data_flow() -> str:
    """The picture as SVG."""
    width, height = SIZE
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" role="img" aria-label="Data flow of circumspect">',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" fill="#475569"/></marker></defs>',
        f'<rect width="{width}" height="{height}" rx="8" fill="#ffffff"/>',
    ]
    parts += [
        f'<path d="M{x0} {y0}L{x1} {y1}" stroke="#475569" stroke-width="2" '
        'marker-end="url(#tip)" fill="none"/>'
        for (x0, y0), (x1, y1) in ARROWS
    ]
    parts += [text(x, y, note, 13, "#475569") for x, y, note in NOTES]
    for left, top, title, result, packages in BOXES.values():
        parts.append(
            f'<rect x="{left}" y="{top}" width="{BOX[0]}" height="{BOX[1]}" rx="6" '
            'fill="#eff6ff" stroke="#1d4ed8" stroke-width="1.5"/>'
        )
        parts.append(text(left + 12, top + 24, title, 17, "#0f172a", "bold"))
        parts.append(text(left + 12, top + 45, result, 14, "#0f172a"))
        parts.append(text(left + 12, top + 64, packages, 13, "#1d4ed8"))
    return "\n".join([*parts, "</svg>", ""])


def text(x: int, y: int, words: str, size: int, colour: str, weight: str = "normal") -> str:
    """One line of text."""
    return (
        f'<text x="{x}" y="{y}" font-size="{size}" font-weight="{weight}" '
        f'fill="{colour}">{escape(words)}</text>'
    )


def main() -> None:
    """Write the picture."""
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("--out", type=Path, default=Path(__file__).with_name("data-flow.svg"))
    with atomic_open(reader.parse_args().out) as stream:
        stream.write(data_flow())


if __name__ == "__main__":
    main()
