"""How soon odometry on another clock is noticed: `python -m benchmarks.odometry_lags`.

Simulated drives without images: the true poses with normal errors stand for registration, and each
wheel slips by itself. One half of the drives goes round an object, turning less and less or more
and more; the other half turns, drives and stands by turns.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import RESULTS, progress_report, write_page
from circumspect.evaluation.markdown import table
from circumspect.geometry import PlanarPose
from circumspect.robot import DifferentialDrive, Velocity
from circumspect.simulation.robot_physics import WheelSlip
from circumspect.tracking.odometry_check import MIN_FRAMES, MIN_SPAN_S, odometry_lag

COMMAND = "python -m benchmarks.odometry_lags"
TICK_S = 0.1
DURATION_S = 100.0
SPEEDS_M_S = (0.05, 0.2)
INTERVALS_S = (0.2, 0.5, 1.0, 2.0)
LAGS_S = (0.0, 0.2, -0.5, 0.5, -1.0, 1.0)
USUAL_S = 0.2
"""Smaller lags are no fault."""
SLIP = 0.05
REGISTRATION_SIGMAS = (0.002, 0.002, 0.002)
"""Of the registered poses [m], [rad]."""
ACCELERATION, TURN_ACCELERATION = 0.3, 1.0
"""Of the robot [m/s²], [rad/s²]."""


@dataclass(frozen=True)
class Drive:
    """A simulated drive.

    Attributes:
        times: (n,) [s].
        true: (n, 3) x, y [m] and yaw [rad] of the base.
        odometry: (n, 3) the same by the wheels.
    """

    times: NDArray[np.floating]
    true: NDArray[np.floating]
    odometry: NDArray[np.floating]

    def frames(
        self, interval_s: float, lag_s: float, rng: np.random.Generator
    ) -> tuple[NDArray[np.floating], ...]:
        """Stamps (m,), registered poses (m, 3) and odometry (m, 3) of frames."""
        stamps = np.arange(2.0, self.times[-1] - 2.0, interval_s)
        registered = self._at(stamps, self.true)
        registered += rng.normal(size=registered.shape) * REGISTRATION_SIGMAS
        return stamps, registered, self._at(stamps - lag_s, self.odometry)

    def _at(self, when: NDArray[np.floating], poses: NDArray[np.floating]) -> NDArray[np.floating]:
        return np.column_stack([np.interp(when, self.times, column) for column in poses.T])


def simulated_drive(seed: int, speed: float, orbits: bool) -> Drive:
    """Drive a robot whose wheels slip.

    Args:
        seed: Of its slip and of its commands.
        speed: [m/s].
        orbits: Whether it drives round an object; else it turns, drives and stands by turns.
    """
    rng = np.random.default_rng(seed)
    drive, slip = DifferentialDrive(), WheelSlip(SLIP, rng.spawn(1)[0])
    command = _orbit(speed, rng) if orbits else _manoeuvres(speed, rng)
    count = round(DURATION_S / TICK_S)
    forward = turn = 0.0
    true, reported = [PlanarPose()], [PlanarPose()]
    for tick in range(count):
        wanted = command[tick]
        forward += float(np.clip(wanted.forward - forward, *_limits(ACCELERATION)))
        turn += float(np.clip(wanted.turn - turn, *_limits(TURN_ACCELERATION)))
        angles = [TICK_S * speed for speed in drive.wheel_speeds(Velocity(forward, turn))]
        moved = [(1 - slip.slip(wheel)) * angle for wheel, angle in enumerate(angles)]
        true.append(true[-1] @ drive.motion(*moved))
        # The mean slip is known from a calibration drive.
        reported.append(reported[-1] @ drive.motion(*((1 - SLIP) * angle for angle in angles)))
        for wheel, angle in enumerate(angles):
            slip.roll(wheel, angle * drive.wheel_radius)
    return Drive(TICK_S * np.arange(count + 1), _rows(true), _rows(reported))


def _limits(acceleration: float) -> tuple[float, float]:
    return -acceleration * TICK_S, acceleration * TICK_S


def _orbit(speed: float, rng: np.random.Generator) -> list[Velocity]:
    """Round an object on arcs whose radius changes."""
    times = np.arange(0.0, DURATION_S, TICK_S)
    radius, period = rng.uniform(1.0, 3.0), rng.uniform(30.0, 120.0)
    sway = 1 + rng.uniform(0.3, 1.0) * np.sin(2 * np.pi * times / period + rng.uniform(0, 6.3))
    return [Velocity(speed, speed / radius * share) for share in sway]


def _manoeuvres(speed: float, rng: np.random.Generator) -> list[Velocity]:
    """Straight and curved segments, turns and stops of 1 to 6 s."""
    commands: list[Velocity] = []
    while len(commands) < DURATION_S / TICK_S:
        kind = rng.integers(4)
        turn = 0.0 if kind in (0, 3) else rng.uniform(-0.4, 0.4)
        velocity = Velocity(speed if kind in (0, 1) else 0.0, turn)
        commands += [velocity] * int(rng.integers(10, 60))
    return commands


def _rows(poses: list[PlanarPose]) -> NDArray[np.floating]:
    rows = np.array([(pose.x, pose.y, pose.yaw) for pose in poses])
    return np.column_stack([rows[:, :2], np.unwrap(rows[:, 2])])


def frames_until_noticed(
    stamps: NDArray[np.floating],
    registered: NDArray[np.floating],
    odometry: NDArray[np.floating],
) -> int | None:
    """Number of frames up to a warning; None if there is none."""
    begin = 0
    for end in range(2, len(stamps) + 1):
        while end - begin > MIN_FRAMES and stamps[end - 1] - stamps[begin] > MIN_SPAN_S:
            begin += 1
        window = slice(begin, end)
        if odometry_lag(stamps[window], registered[window], odometry[window]) is not None:
            return end
    return None


def measured(drives: int) -> list[dict[str, Any]]:
    """One row for each kind of drive, interval and lag."""
    rows, report = [], progress_report()
    cases = list(product((True, False), INTERVALS_S, LAGS_S))
    for number, (orbits, interval, lag) in enumerate(cases):
        noticed: list[int | None] = []
        for seed, speed in product(range(drives // 2), SPEEDS_M_S):
            frames = simulated_drive(seed, speed, orbits).frames(
                interval, lag, np.random.default_rng(seed)
            )
            noticed.append(frames_until_noticed(*frames))
        rows.append({"orbits": orbits, "interval_s": interval, "lag_s": lag, "frames": noticed})
        report(number, len(cases), f"{interval} s, lag {lag} s")
    return rows


def page_text(rows: list[dict[str, Any]]) -> str:
    """The page's text."""
    lines = []
    for row in rows:
        noticed = [count for count in row["frames"] if count is not None]
        lines.append([
            "orbit" if row["orbits"] else "manoeuvres", f"{row['interval_s']:g}",
            f"{row['lag_s']:g}", "" if abs(row["lag_s"]) <= USUAL_S else "yes",
            f"{len(noticed)} of {len(row['frames'])}",
            *([f"{np.median(noticed):.0f}", f"{max(noticed)}"] if noticed else ["", ""]),
        ])  # fmt: skip
    return (
        f"Drives of {DURATION_S:g} s at {' and '.join(f'{s:g}' for s in SPEEDS_M_S)} m/s with "
        f"{SLIP:.0%} slip. Lags up to {USUAL_S:g} s are usual latencies: a warning is wrong "
        "there.\n\n"
        + table(
            ["drive", "frames every [s]", "lag [s]", "fault", "noticed", "median frame", "latest"],
            lines,
        )
    )


def main() -> int:
    """Measure and write `odometry_lags.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=10, help="of each row")
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    rows = measured(given.drives)
    write_page(
        "odometry_lags", "Odometry on another clock", COMMAND, page_text(rows), {"rows": rows},
        given.out,
    )  # fmt: skip
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
