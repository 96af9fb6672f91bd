"""Answers to two objects in real frames: `python -m benchmarks.redkitchen_answers DIR`.

`circumspect replay` classifies the object in a box, with the recorded poses and with its own
estimates. The boxes were chosen by hand on a plan view of the fused frames.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.redkitchen import FOLDER
from benchmarks.report import RESULTS, progress_report, write_page
from circumspect.classification.answer_text import percent
from circumspect.evaluation.markdown import table

BOXES = {
    "chair": ("-1.445", "0.746", "1.811", "-0.947", "-0.337", "2.101"),
    "table": ("-1.017", "0.819", "1.618", "1.263", "-0.217", "2.222"),
}
POSES = ("given", "hidden")
HEAD = ("object", "poses", "answer", "next", "confident", "frames", "coverage", "points")


def main() -> int:
    """Replay, print and write `redkitchen.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=FOLDER)
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    report, runs = progress_report(), []
    jobs = [(name, poses) for name in BOXES for poses in POSES]
    for done, (name, poses) in enumerate(jobs):
        report(done, len(jobs), f"{name}, {poses}")
        runs.append({"object": name, "poses": poses, **replayed(arguments.folder, name, poses)})
    commands = "\n".join(" ".join(words(Path("redkitchen"), *job)) for job in jobs)
    text = (
        f"The first {runs[0]['frames']} even frames of 7-Scenes' RedKitchen, by\n\n"
        f"```\n{commands}\n```\n\n{table(HEAD, [row(run) for run in runs])}\n\n"
        "Frames: those that show the object. Coverage: share of the azimuth seen.\n\n"
        + "\n".join(f"- {run['object']}, {run['poses']}: {verdict(run)}" for run in runs)
    )
    command = "python -m benchmarks.redkitchen_answers"
    title = "Real frames: RedKitchen of 7-Scenes"
    write_page("redkitchen", title, command, text, {"runs": runs}, arguments.out)
    return 0


def words(folder: Path, name: str, poses: str) -> list[str]:
    """The command that classifies an object."""
    box = BOXES[name]
    return ["circumspect", "replay", str(folder), "--box", *box, "--poses", poses, "--json"]


def replayed(folder: Path, name: str, poses: str) -> dict[str, Any]:
    """The command's result for an object, without times."""
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", *words(folder, name, poses), "--out", out]
        done = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        # The command has printed the error.
        sys.exit(done.returncode)
    found = json.loads(done.stdout)
    kept = (
        "label", "in_distribution", "confident", "reason", "probabilities", "frames", "outcomes",
        "coverage", "points",
    )  # fmt: skip
    return {key: found[key] for key in kept}


def verdict(run: dict[str, Any]) -> str:
    """Whether the answer is confident, or the reason why not."""
    if run["confident"]:
        return "confident"
    return f"not confident: {run['reason']}"


def row(run: dict[str, Any]) -> list[str]:
    """Cells of a table row."""
    first, second = sorted(run["probabilities"].items(), key=lambda pair: -pair[1])[:2]
    return [
        run["object"],
        run["poses"],
        f"{first[0]} {percent(first[1])}",
        f"{second[0]} {percent(second[1])}",
        "yes" if run["confident"] else "no",
        f"{run['outcomes'].get('classified', 0)} of {run['frames']}",
        percent(run["coverage"]),
        f"{run['points']:,}",
    ]


if __name__ == "__main__":
    sys.exit(main())
