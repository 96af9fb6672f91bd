"""Real frames with hidden poses: registration alone, with constant velocity as the prior.

    python -m benchmarks.redkitchen DIR

Only the pose of the first frame is given; it defines the map. The other recorded poses are compared
with the estimates, live and after the last correction. small_gicp alone is a baseline on the same
frames: it registers each frame to a map of all frames before.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from benchmarks.plain_gicp import THREADS, VOXEL, PlainGicp
from benchmarks.report import RESULTS, write_page
from circumspect.evaluation.markdown import table
from circumspect.evaluation.trajectory_error import (
    TrajectoryError,
    places_and_turns,
    relative_pose_error,
)
from circumspect.geometry import Trajectory
from circumspect.recording import open_recording
from circumspect.registration import DownsamplingSettings
from circumspect.tracking import PoseEstimate, Tracker

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "data" / "redkitchen"
NAME = "redkitchen_registration"
RANGES = {"small_gicp": DownsamplingSettings().max_depth, "small_gicp_all": float("inf")}
"""Runs of small_gicp, with their maximum depth [m]: the package's limit, and no limit."""


@dataclass(frozen=True, eq=False)
class Run:
    """Results of a recording.

    Attributes:
        truth: The recorded poses.
        estimates: Live estimate of each frame.
        final: The same after all corrections.
        milliseconds: (n,) time of each frame without reading it [ms].
    """

    truth: Trajectory
    estimates: tuple[PoseEstimate, ...]
    final: Trajectory
    milliseconds: np.ndarray

    @property
    def live(self) -> Trajectory:
        """The live poses."""
        poses = RigidTransform.concatenate([pose.T_map_camera for pose in self.estimates])
        return Trajectory(self.truth.stamps, poses)


def run(folder: Path, every: int, frames: int | None) -> Run:
    """Register all frames of a recording."""
    poses, estimates, true, stamps, spent = Tracker(), [], [], [], []
    for number, frame in enumerate(islice(open_recording(folder, every), frames)):
        true.append(frame.pose)
        stamps.append(frame.stamp)
        seen = frame if number == 0 else replace(frame, T_map_camera=None)
        start = time.perf_counter()
        estimates.append(poses.track(seen))
        spent.append(1e3 * (time.perf_counter() - start))
    poses.finalise()
    final = RigidTransform.concatenate(poses.corrected(estimates))
    truth = Trajectory(np.array(stamps), RigidTransform.concatenate(true))
    return Run(truth, tuple(estimates), Trajectory(truth.stamps, final), np.array(spent))


def run_plain(
    folder: Path, every: int, frames: int | None, max_depth: float
) -> tuple[RigidTransform, np.ndarray]:
    """Poses and times [ms] of small_gicp alone."""
    poses, found, spent = PlainGicp(max_depth), [], []
    for frame in islice(open_recording(folder, every), frames):
        start = time.perf_counter()
        found.append(poses.track(frame))
        spent.append(1e3 * (time.perf_counter() - start))
    return RigidTransform.concatenate(found), np.array(spent)


def figures(result: Run, plain: Mapping[str, tuple[RigidTransform, np.ndarray]]) -> dict[str, Any]:
    """All figures, in JSON types.

    Args:
        result: Result of this package.
        plain: Poses and times [ms] of the baselines.
    """
    stamps = result.truth.stamps
    found = {
        "live": (result.live, result.milliseconds),
        "corrected": (result.final, result.milliseconds),
        **{name: (Trajectory(stamps, poses), took) for name, (poses, took) in plain.items()},
    }
    return {
        "frames": len(result.estimates),
        "states": dict(Counter(pose.state for pose in result.estimates)),
        **{name: _errors(poses, result.truth, took) for name, (poses, took) in found.items()},
    }


def _errors(found: Trajectory, truth: Trajectory, took: np.ndarray) -> dict[str, Any]:
    return {
        "absolute": places_and_turns(found, truth).to_dict(),
        "per_frame": relative_pose_error(found, truth).to_dict(),
        "milliseconds": {
            "median": float(np.median(took)), "p95": float(np.percentile(took, 95)),
        },
    }  # fmt: skip


HEAD = [
    "poses", "ATE RMSE [mm]", "ATE median", "ATE max", "rotation RMSE [°]",
    "per frame RMSE [mm]", "per frame median", "time median [ms]", "time 95 %",
]  # fmt: skip
WORDS = {
    "live": "live, at each frame",
    "corrected": "corrected at the end",
    "small_gicp": f"small_gicp, depth to {RANGES['small_gicp']:g} m",
    "small_gicp_all": "small_gicp, all depth",
}


def rows(measured: Mapping[str, Any]) -> list[list[str]]:
    """One row for each kind of poses."""
    lines = []
    for name, words in WORDS.items():
        absolute = TrajectoryError(**measured[name]["absolute"])
        step = TrajectoryError(**measured[name]["per_frame"])
        took = measured[name]["milliseconds"]
        lines.append([
            words, f"{1e3 * absolute.rmse_m:.1f}", f"{1e3 * absolute.median_m:.1f}",
            f"{1e3 * absolute.max_m:.1f}", f"{absolute.rotation_rmse_deg:.2f}",
            f"{1e3 * step.rmse_m:.1f}", f"{1e3 * step.median_m:.1f}",
            f"{took['median']:.0f}", f"{took['p95']:.0f}",
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
    source = arguments.folder, arguments.every, arguments.frames
    plain = {name: run_plain(*source, max_depth) for name, max_depth in RANGES.items()}
    measured = figures(run(*source), plain)
    states = ", ".join(f"{state}: {count}" for state, count in measured["states"].items())
    text = (
        f"{table(HEAD, rows(measured))}\n\n{measured['frames']} frames; states {states}; load "
        f"{os.getloadavg()[0]:.1f}. small_gicp: voxelised GICP to a map of all frames before, "
        f"voxels of {100 * VOXEL:g} cm, constant velocity, {THREADS} threads. It rejects no "
        "registration and corrects no pose. Per frame: relative pose error to the frame before."
    )
    title = "RedKitchen with hidden poses"
    write_page(NAME, title, "python -m benchmarks.redkitchen", text, measured, arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
