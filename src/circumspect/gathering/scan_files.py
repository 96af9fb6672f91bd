"""The files of a scan in a gathered set."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from circumspect.datasets.gathered_set import FOLDERS, write_cloud
from circumspect.geometry import Trajectory, write_tum
from circumspect.recognition import RecognitionResult
from circumspect.runs.run_path import camera_path


def write_scan(
    folder: Path, name: str, result: RecognitionResult, odometry: Trajectory | None
) -> dict[str, str]:
    """Write the files of a scan.

    Args:
        folder: Of the set.
        name: Of the scan.
        result: Of its run.
        odometry: The camera by the wheels alone.

    Returns:
        Kind to path inside the folder, of the written files.

    Raises:
        OutputError: A file cannot be written.
    """
    suffixes = {"cloud": "npz", "grid": "npz", "poses": "txt", "odometry": "txt"}
    places = {kind: f"{FOLDERS[kind]}/{name}.{suffix}" for kind, suffix in suffixes.items()}
    written: dict[str, str] = {}
    last, path = result.last, camera_path(result)
    if last is not None and last.grid is not None:
        write_cloud(folder / places["cloud"], last.model.cloud())
        (folder / places["grid"]).parent.mkdir(parents=True, exist_ok=True)
        last.grid.save(folder / places["grid"])
        written |= {kind: places[kind] for kind in ("cloud", "grid")}
    for kind, trajectory in (("poses", path), ("odometry", odometry)):
        if trajectory is not None:
            write_tum(folder / places[kind], trajectory)
            written[kind] = places[kind]
    return written


def scan_quality(result: RecognitionResult) -> dict[str, Any]:
    """The robot's own measures of a scan's quality, JSON types."""
    prediction, last = result.prediction, result.last
    poses = [step.pose for step in result.steps if step.pose is not None]
    reliable = float(np.mean([pose.reliable for pose in poses])) if poses else 0.0
    return {
        "frames": len(result.steps),
        "reliable": reliable,
        "coverage": 0.0 if last is None else last.coverage,
        "points": 0 if last is None or last.grid is None else len(last.model.cloud()),
        "answer": None if prediction is None else prediction.label,
        "probability": None if prediction is None else prediction.probability,
    }
