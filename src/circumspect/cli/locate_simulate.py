"""`circumspect locate simulate`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from circumspect.cli.given_flags import flags_named
from circumspect.cli.say import say


@dataclass(frozen=True)
class Simulate:
    """A simulated robot drives round an object under ceiling cameras.

    $ circumspect locate simulate
    $ circumspect locate simulate --cameras 6 --seed 3 --json
    $ circumspect locate simulate --calibrate none --seconds 20 --images images
    """

    cameras: int = 4
    """How many."""
    ceiling: float = 3.0
    """Height of the cameras above the floor [m]."""
    speed: float = 0.2
    """The robot's speed [m/s]."""
    seconds: float = 60.0
    """How long it drives at most; once round the object is enough."""
    rate: float = 10.0
    """Images a second of each camera."""
    slip: float = 0.05
    """Share of the wheels' travel that does not become motion."""
    calibrate: Literal["all", "extrinsics", "none"] = "extrinsics"
    """What is calibrated from images first: lens and place, the place alone, or nothing, which
    takes the simulated cameras' true calibration."""
    size: tuple[int, int] = (1280, 960)
    """Of the images [px]."""
    moved: str | None = None
    """Name of a camera that is knocked 40 mm aside after calibration, ceiling_0 for example."""
    seed: int | None = None
    """The same seed gives the same run; without it a new one is drawn."""
    images: Path | None = None
    """Also write to this folder what the other subcommands take: track/, floor/ with survey.json,
    board/, and calibration.json."""
    out: Path | None = None
    """Folder of the run; runs/locate-DATE-TIME by default."""
    json: bool = False
    """One JSON line on standard output and nothing else there."""

    def run(self) -> int:
        """Drive, track, compare, draw."""
        from circumspect.cli.located_run import LocatedRun
        from circumspect.cli.run_screen import new_run_folder
        from circumspect.cli.scan import drawn_seed
        from circumspect.cli.simulated_space import SIMULATED, SimulatedSpace, SpaceSetup
        from circumspect.cli.simulated_views import SimulatedViews

        setup = SpaceSetup(
            self.cameras, self.ceiling, self.speed, self.seconds, self.rate, self.slip,
            self.calibrate, self.moved, drawn_seed(self.seed), self.size,
        )  # fmt: skip
        views = None if self.images is None else SimulatedViews(self.images)
        located = LocatedRun(self.out or new_run_folder("locate"), SIMULATED)
        with flags_named(self, "slip", "ceiling"):
            space = SimulatedSpace.prepared(setup)
        say(f"{self.cameras} cameras at {self.ceiling:g} m, seed {setup.seed}")
        if views is None:
            space.drive(say)
        else:
            views.calibration(space)
            space.drive(say, views.save)
        record = space.save(located)
        print(json.dumps(record) if self.json else _told(record))  # noqa: T201
        return 0


def _told(record: dict[str, Any]) -> str:
    error, states = record["error"], record["states"]
    lines = []
    if error is None:
        lines.append("The robot was never located.")
    else:
        lines += [
            f"Located {states.get('tracked', 0)} of {record['times']} times,"
            f" {states.get('bridged', 0)} bridged.",
            f"Place: {1e3 * error['position_rmse_m']:.2f} mm RMSE,"
            f" {1e3 * error['position_max_m']:.2f} mm at most"
            f" (stated: {1e3 * record['space_error_m']:.2f} mm).",
            f"Heading: {error['yaw_rmse_deg']:.3f}° RMSE, {error['yaw_max_deg']:.3f}° at most.",
        ]
    lines.append(f"Odometry alone ended {1e3 * record['odometry_end_m']:.0f} mm off.")
    lines.append(
        f"{record['milliseconds']:.0f} ms for {record['setup']['cameras']} images at a time: "
        f"{record['rate_hz']:.0f} times a second."
    )
    lines += record["reports"]
    lines.append(f"All of it is in {record['run']}; begin with space.png there")
    return "\n".join(lines)
