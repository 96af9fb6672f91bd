"""Benchmark page of the documentation, assembled from the committed results.

python -m benchmarks.page            # writes docs/benchmarks.md
python -m benchmarks.page --check    # fails if it is not up to date
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from pathlib import Path
from typing import Any

from benchmarks.report import RESULTS
from circumspect.evaluation.markdown import table
from circumspect.storage import atomic_open

PAGE = Path(__file__).resolve().parents[1] / "docs" / "benchmarks.md"
HEAD = """# Benchmarks

`python -m benchmarks.page` makes this page from the tables in `benchmarks/results/`. Each section
gives its command, and most give the machine. [Scans](scans.md) explains the figures of the scans
and their classifier, [real frames](real-frames.md) those of RedKitchen, and [networks](networks.md)
the networks. "The shipped classifier" is [`modelnet10`](models/modelnet10.md). In the comparison at
random yaw it uses its eight [dithered](networks.md#dithered-grids) grids. At 0°, in robustness and
for unknown objects it uses four grids without dithering.
"""
SECTIONS = (
    "grid_speed", "classifier_speed", "modelnet10_test", "cell_borders", "lookalikes", "few_points",
    "any_way_up_choice", "any_way_up", "deletion", "table2", "table2_robot", "rivals/rivals",
    "rivals_random_yaw/rivals", "robustness", "moon2018_robustness", "real", "real_objects/report",
    "left_out_rooms", "committees", "unknown", "scans", "scan_answers", "point_surfaces", "faults",
    "fault_pairs", "fault_rules", "odometry_lags", "calibration", "scan_memory",
    "redkitchen_registration", "redkitchen", "ablation", "ablation_old", "depth_limits",
    "gtsam_trial", "recording", "large_bags", "ros_wire", "dashboard", "intelligent_space",
    "training_speed", "augmentation_speed", "shard_formats", "scale",
)  # fmt: skip
"""Results in the order of the page; missing results are left out."""
LINK = re.compile(r"\]\((?!https?:)([^)#]+)\)")


def page(results: Path) -> str:
    """The page's text."""
    parts = [HEAD]
    for name in SECTIONS:
        # An experiment has a folder with its table and the figures of the table.
        found = next(iter([*results.glob(f"{name}.md"), *results.glob(f"*/{name}.md")]), None)
        if found is not None:
            parts.append(_section(found))
        elif (results / name / "metrics.json").is_file():
            parts.append(_evaluated(results / name))
    return "\n".join(parts)


def _section(found: Path) -> str:
    """A result with headings one level lower and links relative to the docs."""

    def from_docs(link: re.Match[str]) -> str:
        return f"]({os.path.relpath(found.parent / link[1], PAGE.parent)})"

    lines, fenced = [], False
    for line in found.read_text(encoding="utf-8").splitlines():
        fenced ^= line.startswith("```")
        lines.append(f"#{line}" if line.startswith("#") and not fenced else line)
    return LINK.sub(from_docs, "\n".join(lines).strip()) + "\n"


def _evaluated(folder: Path) -> str:
    """Result of `circumspect evaluate` for `modelnet10`."""
    found: dict[str, Any] = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
    mean = sum(found["accuracy"]) / len(found["accuracy"])
    row = [
        str(found["objects"]), str(len(found["yaw_deg"])), f"{mean:.4f}", f"{found['worst']:.4f}",
        f"{found['spread']:.4f}", f"{found['flip_rate']:.2%}",
        f"{found['expected_calibration_error']:.3f}",
    ]  # fmt: skip
    head = ["objects", "yaws", "mean", "worst", "spread", "flips", "calibration error"]
    return (
        "## The classifier `modelnet10` on ModelNet10's test objects\n\n"
        "`circumspect evaluate --data modelnet10 --split test --yaw-count 64`\n\n"
        + table(head, [row])
        + "\n"
    )


def main() -> int:
    """Write the page, or compare it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    text = page(RESULTS)
    if parser.parse_args().check:
        return int(not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != text)
    with atomic_open(PAGE) as stream:
        stream.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
