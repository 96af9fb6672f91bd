"""Frames of simulated scans on disk, so that trackers can be compared on the same frames.

    python -m benchmarks.recorded_scans            # records missing scans

The tracker of this version drives the robot. A file contains depth (16-bit PNG), odometry, mount
and true pose of every frame of a scan. The files are in `runs/` and are not committed.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from benchmarks.fault_scenarios import FaultJob, prepared_fault
from benchmarks.report import progress_report
from benchmarks.scan_job import ScanJob
from benchmarks.scans import furniture_jobs
from circumspect.gathering.job_pool import LocalPool, run_all
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import Odometry, RgbdFrame
from circumspect.simulation import GroundTruthRecorder
from circumspect.storage import atomic_open

FOLDER = Path("runs") / "recorded_scans"
KIDNAPPED = "robot kidnapped"
OBJECTS = ("chair", "sofa", "night_stand")
"""Objects of the scans with faults."""
TRACKED_FAULTS = (
    "blackout of 5 s", "odometry gone from the start", "odometry jumping", "odometry stuck",
    "robot blocked for 20 s", KIDNAPPED, "one wheel 2 % larger",
    "object from wall to wall",
)  # fmt: skip
"""Faults that affect the tracker."""
MAX_FRAMES = 400


@dataclass(frozen=True, eq=False)
class RecordedScan:
    """Frames without poses, and the truth.

    Attributes:
        name: Name of the file without its suffix.
        frames: Frames in order of time.
        truth: n true poses `T_world_camera`.
    """

    name: str
    frames: Sequence[RgbdFrame]
    truth: RigidTransform


class FrameRecorder(WrappedRobot):
    """Records every frame with its true pose."""

    def __init__(self, robot: MobileRobot, ground_truth: GroundTruthRecorder) -> None:
        """Record the frames of a robot with the poses of a ground-truth recorder."""
        super().__init__(robot)
        self.frames: list[tuple[RgbdFrame, NDArray[np.float64]]] = []
        self._ground_truth = ground_truth

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`."""
        frame = super().observe()
        self.frames.append((frame, self._ground_truth.simulated.truth().T_map_camera.as_matrix()))
        return frame


def record(job: FaultJob) -> dict[str, Any]:
    """Drive a scan and write its frames."""
    parts = prepared_fault(job)
    recorder = FrameRecorder(parts.scan.robot, parts.ground_truth)
    scan = parts.driven_by(recorder).scan
    scan.run()
    write(path_of(job), recorder.frames)
    return {"key": job.key, "frames": len(recorder.frames), "ended": scan.ended}


def path_of(job: FaultJob) -> Path:
    """The file of a scan."""
    name = f"{job.fault}.{job.scan.object}".replace(" ", "_").replace("%", "percent")
    return FOLDER / f"{name}.npz"


def write(path: Path, rows: Sequence[tuple[RgbdFrame, NDArray[np.float64]]]) -> None:
    """Write frames and true poses."""
    frames, truth = zip(*rows, strict=True)
    images = [_encoded(frame.depth) for frame in frames]
    camera, nothing = frames[0].camera, np.full((4, 4), np.nan)
    odometry = [frame.odometry for frame in frames]
    with atomic_open(path, "wb") as file:
        np.savez(
            file,
            images=np.concatenate(images),
            offsets=np.cumsum([0, *map(len, images)]),
            stamps=[frame.stamp for frame in frames],
            odometry=[
                (np.nan,) * 4 if o is None
                else (o.stamp, o.T_odom_base.x, o.T_odom_base.y, o.T_odom_base.yaw)
                for o in odometry
            ],
            covariances=[np.zeros((3, 3)) if o is None else o.covariance for o in odometry],
            mounts=[
                nothing if frame.T_base_camera is None else frame.T_base_camera.as_matrix()
                for frame in frames
            ],
            truth=np.stack(truth),
            size=[camera.width, camera.height],
            intrinsics=[camera.fx, camera.fy, camera.cx, camera.cy],
        )  # fmt: skip


def read(path: Path) -> RecordedScan:
    """Read a recorded scan."""
    with np.load(path) as data:
        width, height = map(int, data["size"])
        camera = PinholeCamera(width, height, *map(float, data["intrinsics"]))
        images, offsets = data["images"], data["offsets"]
        frames = [
            RgbdFrame(
                _decoded(images[offsets[n] : offsets[n + 1]]), camera, float(stamp),
                odometry=_odometry(data["odometry"][n], data["covariances"][n]),
                T_base_camera=_mount(data["mounts"][n]),
            )
            for n, stamp in enumerate(data["stamps"])
        ]  # fmt: skip
        return RecordedScan(path.stem, frames, RigidTransform.from_matrix(data["truth"]))


def jobs(each: int, each_fault: int, frames: int) -> list[FaultJob]:
    """The furniture scans of `benchmarks.scans`, and `each_fault` objects with each fault.

    All objects are scanned with a kidnapping, because these few scans evaluate relocalisation.
    """
    furniture = [FaultJob("none", replace(scan, frames=frames)) for scan in furniture_jobs(each)]
    faults = [
        FaultJob(fault, ScanJob("faults", f"{category}-{100_010 + number}", 30.0 + 110 * number,
                                number, "normals", 0.5, frames))
        for fault in TRACKED_FAULTS
        for number, category in enumerate(OBJECTS)
        if number < each_fault or fault == KIDNAPPED
    ]  # fmt: skip
    return [*furniture, *faults]


def main() -> int:
    """Record missing scans."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=6, help="furniture scans of each class")
    parser.add_argument("--each-fault", type=int, default=len(OBJECTS), help="scans of each fault")
    parser.add_argument("--frames", type=int, default=MAX_FRAMES, help="maximum frames of a scan")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    wanted = jobs(given.each, given.each_fault, given.frames)
    run_all(wanted, record, FOLDER / "recorded.jsonl", LocalPool(given.workers), progress_report())
    return 0


def _encoded(depth: NDArray[np.float32]) -> NDArray[np.uint8]:
    millimetres = np.nan_to_num(np.rint(1000 * depth), nan=0).clip(0, 65535).astype(np.uint16)
    done, image = cv2.imencode(".png", millimetres)
    assert done
    return image.ravel()


def _decoded(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    millimetres = cv2.imdecode(image, cv2.IMREAD_UNCHANGED)
    assert millimetres is not None
    depth = np.asarray(millimetres, np.float32) / np.float32(1000)
    depth[depth <= 0] = np.nan
    return depth


def _odometry(row: NDArray[np.float64], covariance: NDArray[np.float64]) -> Odometry | None:
    if np.isnan(row[0]):
        return None
    stamp, x, y, yaw = map(float, row)
    return Odometry(stamp, PlanarPose(x, y, yaw), covariance)


def _mount(matrix: NDArray[np.float64]) -> RigidTransform | None:
    return None if np.isnan(matrix[0, 0]) else RigidTransform.from_matrix(matrix)


if __name__ == "__main__":
    sys.exit(main())
