"""Simulated scans with faults of the robot, its sensors or its world."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.live_poses import LivePoses, reliability_figures
from benchmarks.provenance import provenance
from benchmarks.scan_job import ROOM, ScanJob, answer_figures, measured, prepared
from circumspect.errors import CircumspectError
from circumspect.exploration.simulated_scan import SimulatedScan
from circumspect.geometry import PlanarPose, TriangleMesh
from circumspect.recognition import RecognitionResult
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.runs.run_path_log import RunPathLog
from circumspect.simulation import (
    Blackout,
    Blocked,
    ClockStartingAt,
    DroppedFrames,
    EqualStamps,
    GroundTruthRecorder,
    Kidnapped,
    NanFrame,
    OdometryCovariance,
    OdometryGone,
    OdometryJumping,
    OdometryLagging,
    OdometryOfAnotherEpoch,
    OdometryStuck,
    Scene,
    SimulatedRobot,
    Surface,
    UnorderedFrames,
    WrongUnit,
    block,
    moved_mesh,
    room,
)

AFTER = 40.0
"""Time at which a fault begins [s], after a sixth of the orbit."""
AWAY = PlanarPose(0.3, -0.1, 0.35)
"""Displacement of a kidnapped robot."""

Wrapper = Callable[[MobileRobot], MobileRobot]
FAULTS: dict[str, Wrapper] = {
    "none": lambda robot: robot,
    "blackout of 5 s": lambda robot: Blackout(robot, AFTER),
    "30 % of the frames dropped": lambda robot: DroppedFrames(robot, 0.3),
    "20 % of the frames late": lambda robot: UnorderedFrames(robot, 0.2),
    "20 % of the stamps twice": lambda robot: EqualStamps(robot, 0.2),
    "a NaN frame": lambda robot: NanFrame(robot, 30),
    "depth in mm from 40 s on": lambda robot: WrongUnit(robot, AFTER),
    "depth in mm from the start": lambda robot: WrongUnit(robot),
    "odometry gone from the start": lambda robot: OdometryGone(robot),
    "odometry gone from 40 s on": lambda robot: OdometryGone(robot, AFTER),
    "odometry jumping": lambda robot: OdometryJumping(robot, AFTER),
    "odometry stuck": lambda robot: OdometryStuck(robot, AFTER),
    "robot blocked for 20 s": lambda robot: Blocked(robot, AFTER, 20.0),
    "robot kidnapped": lambda robot: _kidnapped(robot),
    "clock that starts at zero": lambda robot: ClockStartingAt(robot, 0.0),
    "odometry with NaN covariance": lambda robot: OdometryCovariance(robot, np.nan),
    "odometry with constant covariance": lambda robot: OdometryCovariance(robot, 0.1),
    "clock of the images 0.5 s behind": lambda robot: OdometryLagging(robot, 0.5),
    "clock of the images 1 s behind": lambda robot: OdometryLagging(robot, 1.0),
    "odometry of another epoch": lambda robot: OdometryOfAnotherEpoch(robot),
}
ROOMS = {
    "one wheel 2 % larger": replace(ROOM, wheel_error=0.02),
    "floor with ridges of 5 mm": replace(ROOM, bump_height=0.005),
    "camera with depth distortion": replace(ROOM, distorted=True),
}
NOTHING, BAR, GIANT = (
    "no object in view", "object from wall to wall", "object too large for the camera",
)  # fmt: skip
WORLDS = (*ROOMS, NOTHING, BAR, GIANT)
"""Faults of the world instead of the robot."""
BAR_XYZ = (0.2, 9.0, 0.7)
"""Half thickness, half length and height of the bar from wall to wall [m]."""
EVERY = (*FAULTS, *WORLDS)


@dataclass(frozen=True)
class FaultJob:
    """A scan with one or two faults.

    Attributes:
        fault: One of `FAULTS` or `WORLDS`.
        scan: The scan without its faults.
        second: Another fault at the same time; None for none.
    """

    fault: str
    scan: ScanJob
    second: str | None = None

    @property
    def faults(self) -> tuple[str, ...]:
        """All faults of the scan."""
        return (self.fault,) if self.second is None else (self.fault, self.second)

    @property
    def name(self) -> str:
        """Names of the faults."""
        return " + ".join(self.faults)

    @property
    def key(self) -> str:
        """Unique name."""
        return f"{self.name}/{self.scan.key}"


def run_fault(job: FaultJob) -> dict[str, Any]:
    """Run a scan with faults; the record contains its end reason, in JSON types."""
    made = provenance()
    head = {"key": job.key, "made": made, "fault": job.name, "object": job.scan.object}
    try:
        parts = prepared_fault(job)
    except CircumspectError as error:
        return {**head, "ended": f"refused: {error}", "label": None, "frames": 0}
    scan = parts.scan
    log = RunPathLog(scan)
    live = LivePoses()
    try:
        result = scan.run((log, live))
    except CircumspectError as error:
        return {**head, "ended": f"error: {error}", "label": None, "frames": 0}
    # Without the object, none of the ten classes is correct.
    unlabelled = NOTHING in job.faults or BAR in job.faults
    error = measured(parts, result, log, shape=not unlabelled)
    return {
        **head,
        "true_label": None if unlabelled else parts.config["true_label"],
        **answer_figures(result),
        **_odometry_warning(result),
        "ended": scan.ended,
        "distance_m": scan.driven_m,
        **error.summary(),
        "missing": list(error.missing),
        **reliability_figures(live.estimates, parts.ground_truth.trajectory)._asdict(),
    }


def _odometry_warning(result: RecognitionResult) -> dict[str, Any]:
    """First frame without odometry, and the reason."""
    warned = [step for step in result.steps if step.odometry_warning]
    if not warned:
        return {}
    return {"odometry_unused_from": warned[0].index, "odometry_warning": warned[0].odometry_warning}


def prepared_fault(job: FaultJob) -> SimulatedScan:
    """The scan in its world and with its robot, ready to run."""
    room_names = [fault for fault in job.faults if fault in ROOMS]
    parts = prepared(job.scan, world=ROOMS[room_names[0]] if room_names else ROOM)
    if GIANT in job.faults:
        mesh = parts.room.scene.surfaces[0].mesh
        room(TriangleMesh(8 * mesh.vertices_xyz, mesh.faces), job.scan.seed)
        raise AssertionError("the room accepted an object of eight times the size")
    # Bare walls, because clutter would correctly be segmented as the object.
    bare = tuple(s for s in parts.room.scene.surfaces if s.name.startswith(("floor", "wall")))
    if NOTHING in job.faults:
        parts = _in_scene(parts, bare, job.scan)
    elif BAR in job.faults:
        parts = _in_scene(parts, (_bar(parts.room.orbit.centre_xy, job.scan), *bare), job.scan)
    robot: MobileRobot = parts.ground_truth
    for fault in job.faults:
        robot = FAULTS.get(fault, FAULTS["none"])(robot)
    return parts.driven_by(robot)


def _in_scene(parts: SimulatedScan, surfaces: tuple[Surface, ...], scan: ScanJob) -> SimulatedScan:
    """The same scan in another scene."""
    robot = SimulatedRobot(
        Scene(surfaces), parts.room.start(scan.start_deg), parts.room.mount, seed=scan.seed
    )
    return replace(parts, ground_truth=GroundTruthRecorder(robot))


def _bar(centre_xy: tuple[float, float], scan: ScanJob) -> Surface:
    """A bar from wall to wall across the robot's view."""
    x, y, z = BAR_XYZ
    stand = PlanarPose(*centre_xy, float(np.radians(scan.start_deg)))
    return Surface("object", moved_mesh(block((-x, -y, 0.0), (x, y, z)), stand))


def _kidnapped(robot: MobileRobot) -> MobileRobot:
    """Displace the simulated robot in a way that the ground-truth recorder observes."""
    inner = robot
    while not isinstance(inner, GroundTruthRecorder):
        assert isinstance(inner, WrappedRobot)
        inner = inner.robot
    return _RecordedKidnapping(robot, inner)


class _RecordedKidnapping(Kidnapped):
    """Kidnaps the simulated robot inside of a ground-truth recorder."""

    def __init__(self, robot: MobileRobot, ground_truth: GroundTruthRecorder) -> None:
        super().__init__(ground_truth.simulated, AFTER, AWAY)
        self.robot = robot
