"""Real frames with hidden poses: registration alone, from a constant-velocity prior.

    python -m benchmarks.redkitchen DIR

Only the first frame's pose is given; it says where the map lies. The others are compared with
what comes out: as told at each frame, and as corrected at the end.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from benchmarks.report import RESULTS, write_page
from circumspect.evaluation.markdown import table
from circumspect.evaluation.trajectory_error import (
    TrajectoryError,
    places_and_turns,
    relative_pose_error,
)
from circumspect.geometry import Trajectory
from circumspect.mapping import PoseEstimate, RegisteredPoses
from circumspect.recording import open_recording

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "data" / "redkitchen"
NAME = "redkitchen_registration"


@dataclass(frozen=True, eq=False)
class Run:
    """What came out of a recording.

    Attributes:
        truth: The recorded poses.
        told: What was estimated at each frame.
        final: The same after all corrections.
        milliseconds: (n,) time a frame, reading it left out.
    """

    truth: Trajectory
    told: tuple[PoseEstimate, ...]
    final: Trajectory
    milliseconds: np.ndarray

    @property
    def live(self) -> Trajectory:
        """The poses as they were told."""
        poses = RigidTransform.concatenate([pose.T_map_camera for pose in self.told])
        return Trajectory(self.truth.stamps, poses)


def run(folder: Path, every: int, frames: int | None) -> Run:
    """Register all frames of a recording."""
    poses, told, true, stamps, spent = RegisteredPoses(), [], [], [], []
    for number, frame in enumerate(open_recording(folder, every)):
        if number == frames:
            break
        true.append(frame.pose)
        stamps.append(frame.stamp)
        seen = frame if number == 0 else replace(frame, T_map_camera=None)
        start = time.perf_counter()
        told.append(poses.estimate(seen))
        spent.append(1e3 * (time.perf_counter() - start))
    poses.settle()
    final = RigidTransform.concatenate(poses.corrected(told))
    truth = Trajectory(np.array(stamps), RigidTransform.concatenate(true))
    return Run(truth, tuple(told), Trajectory(truth.stamps, final), np.array(spent))


def figures(result: Run) -> dict[str, Any]:
    """All that is measured, in JSON types."""
    return {
        "frames": len(result.told),
        "gates": dict(Counter(pose.gate for pose in result.told)),
        "milliseconds": {
            "median": float(np.median(result.milliseconds)),
            "p95": float(np.percentile(result.milliseconds, 95)),
        },
        **{
            name: {
                "absolute": asdict(places_and_turns(trajectory, result.truth)),
                "per_frame": asdict(relative_pose_error(trajectory, result.truth)),
            }
            for name, trajectory in (("told", result.live), ("corrected", result.final))
        },
    }


def rows(measured: dict[str, Any]) -> list[list[str]]:
    """One for each kind of poses and error."""
    lines = []
    for name, what in (("told", "as told at each frame"), ("corrected", "corrected at the end")):
        for kind, words in (("absolute", "absolute (ATE)"), ("per_frame", "from frame to frame")):
            error = TrajectoryError(**measured[name][kind])
            lines.append([
                what, words, f"{1e3 * error.rmse_m:.1f}", f"{1e3 * error.median_m:.1f}",
                f"{1e3 * error.max_m:.1f}", f"{error.rotation_rmse_deg:.2f}",
            ])  # fmt: skip
    return lines


def main() -> int:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=FOLDER)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--frames", type=int)
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    measured = figures(run(arguments.folder, arguments.every, arguments.frames))
    head = ["poses", "error", "RMSE [mm]", "median [mm]", "max [mm]", "rotation RMSE [°]"]
    gates = ", ".join(f"{gate}: {count}" for gate, count in measured["gates"].items())
    took = measured["milliseconds"]
    text = (
        f"{table(head, rows(measured))}\n\n{measured['frames']} frames; gate {gates}; "
        f"{took['median']:.0f} ms a frame (95 %: {took['p95']:.0f} ms), load "
        f"{os.getloadavg()[0]:.1f}."
    )
    title = "RedKitchen with hidden poses"
    write_page(NAME, title, "python -m benchmarks.redkitchen", text, measured, arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
