"""Simulated robot under simulated ceiling cameras, for `locate simulate`."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.cli.commands.space_setup import SpaceSetup
from circumspect.cli.located_run import LocatedRun
from circumspect.errors import CircumspectError, InputError
from circumspect.evaluation.space_error import SpaceError, space_error
from circumspect.furniture import make_furniture
from circumspect.geometry import PlanarPose, Trajectory, wrapped, write_tum
from circumspect.localization import (
    Calibration,
    CeilingImage,
    CharucoBoard,
    IntelligentSpace,
    SpaceFix,
    SpaceTrack,
    Survey,
    write_calibration,
)
from circumspect.robot import PathFollower, Velocity
from circumspect.simulation import (
    CeilingRig,
    PlacedPlate,
    RobotSettings,
    Room,
    SimulatedRobot,
    calibrated,
    ceiling_cameras,
    displaced,
    outlines,
    room,
    surveyed_tags,
)

KNOCK = RigidTransform.from_components([0.04, 0.0, 0.0], Rotation.from_rotvec([0.0, 0.0, 0.01]))
"""Displacement of a knocked camera in its own frame."""
AHEAD = float(np.radians(50.0))
"""Angle between the robot and its goal on the circle [rad]."""
PRINT_EVERY_S = 10.0
"""Time between two lines of progress [s of the robot's clock]."""
SIMULATED = CALIBRATION, TRUTH, ODOMETRY = ("calibration.json", "truth.txt", "odometry.txt")
"""Files of a run that only a simulation writes."""


@dataclass(eq=False)
class SimulatedSpace:
    """Robot, room, cameras and results of a simulation.

    Attributes:
        setup: Settings.
        place: The room.
        robot: The robot.
        rig: The cameras in their true poses.
        survey: Surveyed poses of tags on the floor.
        laid: The tags in their true poses.
        calibration: The calibration that localisation uses.
        space: Locates the robot.
        fixes: Its results.
        milliseconds: Duration of each localisation.
    """

    setup: SpaceSetup
    place: Room
    robot: SimulatedRobot
    rig: CeilingRig
    survey: Survey
    laid: tuple[PlacedPlate, ...]
    calibration: Calibration
    space: IntelligentSpace
    fixes: list[SpaceFix] = field(default_factory=list)
    milliseconds: list[float] = field(default_factory=list)
    _truth: list[tuple[float, RigidTransform]] = field(default_factory=list)
    _wheels: list[tuple[float, PlanarPose]] = field(default_factory=list)

    @classmethod
    def prepared(cls, setup: SpaceSetup) -> Self:
        """Furnish a room, place cameras, and calibrate them.

        Raises:
            InputError: A setting is invalid, or the camera to be knocked does not exist.
            MissingExtraError: The simulation, OpenCV or pupil-apriltags is not installed.
        """
        seed = setup.seed
        place = room(make_furniture("chair", seed), seed)
        middle = np.array(place.orbit.centre_xy)
        low, high = middle - place.lane_radius, middle + place.lane_radius
        hung = ceiling_cameras(low, high, setup.cameras, setup.ceiling, size=setup.size, seed=seed)
        if setup.moved is not None and setup.moved not in [camera.name for camera in hung]:
            names = ", ".join(camera.name for camera in hung)
            raise InputError(f"--moved {setup.moved}: no such camera; there are {names}")
        rig = CeilingRig(hung, place.scene, seed=seed)
        survey, laid = surveyed_tags(low, high, rng=seed)
        if setup.calibrate == "none":
            calibration = Calibration.of(hung, rig.mount)
        else:
            board = CharucoBoard() if setup.calibrate == "all" else None
            calibration = calibrated(rig, survey, laid, board, seed)
        if setup.moved is not None:
            after = [displaced(c, KNOCK) if c.name == setup.moved else c for c in hung]
            rig = CeilingRig(after, place.scene, seed=seed)
        start = place.start(float(np.random.default_rng(seed).uniform(0, 360)))
        settings = RobotSettings(slip=setup.slip)
        robot = SimulatedRobot(place.scene, start, place.mount, settings, seed=seed)
        space = IntelligentSpace(calibration.cameras, rig.mount)
        return cls(setup, place, robot, rig, survey, laid, calibration, space)

    def drive(
        self,
        say: Callable[[str], None] = lambda _: None,
        taken: Callable[[Sequence[CeilingImage]], None] = lambda _: None,
    ) -> None:
        """Drive once round the object, controlled by the poses of the intelligent space alone.

        Args:
            say: Prints a line of progress.
            taken: Called with the images of each time.
        """
        follower, turned, printed = PathFollower(), 0.0, 0.0
        last: float | None = None
        while self.robot.now < self.setup.seconds and turned < 2 * np.pi:
            fix = self._look(taken)
            if fix.T_map_base is None:
                self.robot.stop()
            else:
                azimuth = self._azimuth(fix.T_map_base)
                if last is not None:
                    turned += wrapped(azimuth - last)
                last = azimuth
                self.robot.drive(self._steered(follower, fix.T_map_base, azimuth))
            if self.robot.now >= printed + PRINT_EVERY_S:
                printed = self.robot.now
                say(f"{printed:.0f} s, {np.degrees(turned):.0f}° round the object, {fix.state}")
            self.robot.wait(1 / self.setup.rate)
        self.robot.stop()

    def _look(self, taken: Callable[[Sequence[CeilingImage]], None]) -> SpaceFix:
        """Take images and locate the robot in them."""
        truth = self.robot.truth()
        images = self.rig.images(truth)
        taken(images)
        began = time.perf_counter()
        fix = self.space.locate(images)
        self.milliseconds.append(1e3 * (time.perf_counter() - began))
        self.fixes.append(fix)
        self._truth.append((truth.stamp, truth.T_map_base))
        self._wheels.append((truth.stamp, self.robot.odometry().T_odom_base))
        return fix

    def _azimuth(self, pose: PlanarPose) -> float:
        x, y = pose.xy - self.place.orbit.centre_xy
        return float(np.arctan2(y, x))

    def _steered(self, follower: PathFollower, pose: PlanarPose, azimuth: float) -> Velocity:
        way = azimuth + np.linspace(0, AHEAD, 12)
        radius = self.place.orbit.radius + self.place.mount.left
        path = self.place.orbit.centre_xy + radius * np.column_stack([np.cos(way), np.sin(way)])
        goal = PlanarPose(float(path[-1, 0]), float(path[-1, 1]), float(way[-1] + np.pi / 2))
        return follower.velocity(pose, path, goal, self.setup.speed) or Velocity()

    @property
    def track(self) -> SpaceTrack:
        """The poses of the intelligent space so far."""
        return SpaceTrack.of(self.fixes, self.space.reports)

    @property
    def truth(self) -> Trajectory:
        """True poses of the base."""
        stamps, poses = zip(*self._truth, strict=True)
        return Trajectory(np.array(stamps), RigidTransform.concatenate(list(poses)))

    @property
    def odometry(self) -> Trajectory:
        """Poses of the base from wheel odometry, starting at the true first pose."""
        stamps, poses = zip(*self._wheels, strict=True)
        start = PlanarPose.from_transform(self._truth[0][1]) @ poses[0].inverse()
        moved = [(start @ pose).as_transform() for pose in poses]
        return Trajectory(np.array(stamps), RigidTransform.concatenate(moved))

    @property
    def error(self) -> SpaceError | None:
        """Error against the truth; None if the robot was never located."""
        try:
            return space_error(self.track, self.truth)
        except CircumspectError:
            return None

    def record(self) -> dict[str, Any]:
        """Results in JSON types."""
        error, rate = self.error, 1e3 / float(np.median(self.milliseconds))
        off = self.odometry.positions_xyz[-1] - self.truth.positions_xyz[-1]
        return {
            **self.track.summary(),
            "error": None if error is None else error.to_dict(),
            "odometry_end_m": float(np.linalg.norm(off[:2])),
            "milliseconds": float(np.median(self.milliseconds)),
            "rate_hz": rate,
            "setup": asdict(self.setup),
        }

    def save(self, run: LocatedRun) -> dict[str, Any]:
        """Write all files.

        Args:
            run: Folder of the run, made with `SIMULATED` as `more`.

        Raises:
            OutputError: A file can not be written.
        """
        write_calibration(run.path / CALIBRATION, self.calibration)
        write_tum(run.path / TRUTH, self.truth)
        write_tum(run.path / ODOMETRY, self.odometry)
        surface = next(s for s in self.place.scene.surfaces if s.name == "object")
        return run.save(
            self.track,
            self.calibration,
            self.rig.mount,
            {"odometry alone": self.odometry},
            self.record(),
            truth=self.truth,
            walls_xy=outlines(self.place.scene),
            object_xy=surface.mesh.vertices_xyz,
        )
