"""What becomes of a scan when something goes wrong: a table of faults against outcome.

    python -m benchmarks.faults                      # all faults, a few scans each
    python -m benchmarks.faults --only "robot kidnapped"

Every scan is one JSON line in `benchmarks/results/faults.jsonl`; what is there is not done again.
The table is of the scans of all faults that the same settings make.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.asked import command_with, of_jobs
from benchmarks.live_poses import LivePoses, trust
from benchmarks.provenance import made_by, provenance
from benchmarks.report import RESULTS, machine, telling
from benchmarks.scan_job import ROOM, ScanJob, measured, prepared, told
from circumspect.errors import CircumspectError
from circumspect.evaluation.markdown import table
from circumspect.gathering.job_pool import records, run_all
from circumspect.geometry import PlanarPose, TriangleMesh
from circumspect.pipeline.journey_log import JourneyLog
from circumspect.pipeline.scan import ObjectScan
from circumspect.pipeline.simulated_scan import SimulatedScan
from circumspect.robot import MobileRobot
from circumspect.simulation import (
    Blackout,
    Blocked,
    DroppedFrames,
    EqualStamps,
    Kidnapped,
    NanFrame,
    OdometryGone,
    OdometryJumping,
    OdometryStuck,
    Scene,
    SimulatedRobot,
    Surface,
    UnorderedFrames,
    Witness,
    WrongUnit,
    block,
    carried,
    room,
)

AFTER = 40.0
"""When a fault begins [s]: a sixth of the way round."""
OBJECTS = ("chair-100000", "sofa-100000", "night_stand-100000")
AWAY = PlanarPose(0.3, -0.1, 0.35)
"""To where a kidnapper carries the robot."""

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
}
ROOMS = {
    "one wheel 2 % larger": replace(ROOM, wheel_error=0.02),
    "floor with ridges of 5 mm": replace(ROOM, bump_height=0.005),
}
NOTHING, BAR, GIANT = (
    "no object in view", "object from wall to wall", "object too large for the camera",
)  # fmt: skip
WORLDS = (*ROOMS, NOTHING, BAR, GIANT)
"""Faults of the world instead of the robot."""
BAR_XYZ = (0.2, 9.0, 0.7)
"""Half thickness, half length and height of a thing from wall to wall [m]."""
EVERY = (*FAULTS, *WORLDS)
SETTINGS = ("frame_interval", "frames")
"""Flags that tell which scans there are."""


@dataclass(frozen=True)
class FaultJob:
    """A scan with something wrong.

    Attributes:
        fault: One of `FAULTS` or `WORLDS`.
        scan: What would be scanned if all were well.
    """

    fault: str
    scan: ScanJob

    @property
    def key(self) -> str:
        """Tells it from all others."""
        return f"{self.fault}/{self.scan.key}"


def run_fault(job: FaultJob) -> dict[str, Any]:
    """Scan with the fault and say how it ended; JSON types."""
    made = provenance()
    head = {"key": job.key, "made": made, "fault": job.fault, "object": job.scan.object}
    try:
        parts = prepared_fault(job)
        scan = ObjectScan(
            FAULTS.get(job.fault, FAULTS["none"])(parts.witness), parts.pipeline,
            parts.scan.planner, parts.scan.settings,
        )  # fmt: skip
    except CircumspectError as error:
        return {**head, "ended": f"refused: {error}", "label": None, "frames": 0}
    log = JourneyLog(scan)
    live = LivePoses()
    parts.pipeline.observers = (log, live)
    try:
        result = scan.run()
    except CircumspectError as error:
        return {**head, "ended": f"error: {error}", "label": None, "frames": 0}
    # What stands there instead, if anything, is none of the ten things.
    nameless = job.fault in (NOTHING, BAR)
    error = measured(parts, result, log, shape=not nameless)
    return {
        **head,
        "true_label": None if nameless else parts.config["true_label"],
        **told(result),
        "ended": scan.ended,
        "distance_m": scan.driven_m,
        **error.summary(),
        "missing": list(error.missing),
        **trust(live.told, parts.witness.trajectory)._asdict(),
    }


def prepared_fault(job: FaultJob) -> SimulatedScan:
    """The scan in its world; for `WORLDS` another world."""
    parts = prepared(job.scan, world=ROOMS.get(job.fault, ROOM))
    if job.fault == GIANT:
        mesh = parts.room.scene.surfaces[0].mesh
        room(TriangleMesh(8 * mesh.vertices_xyz, mesh.faces), job.scan.seed)
        raise AssertionError("the room took a thing of eight times the size")
    # Bare walls: a thing that stands about would be taken for the object, and rightly so.
    bare = tuple(s for s in parts.room.scene.surfaces if s.name.startswith(("floor", "wall")))
    if job.fault == NOTHING:
        return _in_scene(parts, bare, job.scan)
    if job.fault == BAR:
        return _in_scene(parts, (_bar(parts.room.orbit.centre_xy, job.scan), *bare), job.scan)
    return parts


def _in_scene(parts: SimulatedScan, surfaces: tuple[Surface, ...], scan: ScanJob) -> SimulatedScan:
    """The same scan among other things."""
    robot = SimulatedRobot(
        Scene(surfaces), parts.room.start(scan.start_deg), parts.room.mount, seed=scan.seed
    )
    return replace(parts, witness=Witness(robot))


def _bar(centre_xy: tuple[float, float], scan: ScanJob) -> Surface:
    """A thing from wall to wall, across the robot's view."""
    x, y, z = BAR_XYZ
    stand = PlanarPose(*centre_xy, float(np.radians(scan.start_deg)))
    return Surface("object", carried(block((-x, -y, 0.0), (x, y, z)), stand))


def _kidnapped(robot: MobileRobot) -> MobileRobot:
    """The witness's robot is carried away, and the witness sees it."""
    assert isinstance(robot, Witness)
    return _WitnessedKidnapping(robot)


class _WitnessedKidnapping(Kidnapped):
    """Kidnaps the simulated robot inside of a witness."""

    def __init__(self, witness: Witness) -> None:
        super().__init__(witness.simulated, AFTER, AWAY)
        self.robot = witness


def rows(found: list[dict[str, Any]]) -> list[list[str]]:
    """One a fault, over its scans."""
    lines = []
    for fault in EVERY:
        some = [record for record in found if record["fault"] == fault]
        if some:
            answered = [record for record in some if record["label"] is not None]
            lines.append([
                fault, _correct(answered), _correct([r for r in answered if r.get("confident")]),
                _worst(some, "ate_rmse_m"),
                _while_certain(some), _mean(some, "trusted"),
                _worst(some, "worst_sure_m"), _mean(some, "sure"),
                "; ".join(sorted({str(r["ended"]) for r in some})),
            ])  # fmt: skip
    return lines


def _correct(answered: list[dict[str, Any]]) -> str:
    correct = sum(record["label"] == record.get("true_label") for record in answered)
    return f"{correct} of {len(answered)}"


def _worst(some: list[dict[str, Any]], name: str) -> str:
    known = [1e3 * r[name] for r in some if r.get(name) is not None]
    return f"{max(known):.0f}" if known else "–"


def _while_certain(some: list[dict[str, Any]]) -> str:
    sigmas = [r["worst_trusted_sigmas"] for r in some if r.get("worst_trusted_sigmas") is not None]
    return _worst(some, "worst_trusted_m") + (f" ({max(sigmas):.1f} σ)" if sigmas else "")


def _mean(some: list[dict[str, Any]], name: str) -> str:
    known = [r[name] for r in some if r.get(name) is not None]
    return f"{np.mean(known):.0%}" if known else "–"


def main() -> int:
    """Run what is not there yet and write `faults.md`."""
    given, usual = _parser().parse_args(), _parser().parse_args([])
    path: Path = given.out / "faults.jsonl"
    run_all(jobs(given.only or EVERY, given), run_fault, path, given.workers, telling())
    command = command_with("python -m benchmarks.faults", given, usual, SETTINGS)
    found = of_jobs(records(path), jobs(EVERY, given))
    write(rows(found), given.out, command, made_by(found))
    return 0


def jobs(faults: Sequence[str], given: argparse.Namespace) -> list[FaultJob]:
    """A scan of each object with each of some faults; the same arguments give the same scans."""
    return [
        FaultJob(fault, ScanJob("faults", name, 30.0 + 110 * number, number, "normals",
                                given.frame_interval, given.frames))
        for fault in faults
        for number, name in enumerate(OBJECTS)
    ]  # fmt: skip


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=EVERY, action="append")
    parser.add_argument("--frame-interval", type=float, default=0.5, help="between frames [s]")
    parser.add_argument("--frames", type=int, default=4000, help="at most so many a scan")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    return parser


def write(lines: list[list[str]], folder: Path, command: str, made: str) -> None:
    """Write `faults.md`."""
    head = [
        "fault", "correct answers", "of confident ones", "ATE [mm], worst",
        "certain poses, worst error [mm]", "certain poses",
        "sure poses, worst error [mm]", "sure poses", "ended",
    ]  # fmt: skip
    facts = "".join(f"- {key}: {value}\n" for key, value in machine().items())
    path = folder / "faults.md"
    path.write_text(
        f"# Faults\n\n`{command}`, {len(OBJECTS)} scans a fault "
        f"({', '.join(OBJECTS)}). {made}\n\n{table(head, lines)}\n\n{facts}",
        encoding="utf-8",
    )
    print(path.read_text(encoding="utf-8"))


if __name__ == "__main__":
    sys.exit(main())
