"""`circumspect locate simulate`."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

from circumspect.cli.commands.space_setup import SpaceSetup
from circumspect.cli.config_file import ConfigFlag, write_config
from circumspect.cli.flag_table import Flags
from circumspect.cli.given_flags import drawn_seed, flags_named
from circumspect.cli.say import say

SETUP = Flags(
    "cameras", "ceiling", "speed", "seconds", "rate", "slip", "calibrate", "moved", "size"
)


@dataclass(frozen=True)
class Simulate:
    """Simulate a robot that drives round an object under ceiling cameras.

    $ circumspect locate simulate
    $ circumspect locate simulate --cameras 6 --seed 3 --json
    $ circumspect locate simulate --calibrate none --seconds 20 --images images
    """

    setup: Annotated[SpaceSetup, SETUP] = field(default_factory=SpaceSetup)
    """Simulated cameras, robot and calibration."""
    seed: int | None = None
    """Random seed; the same seed gives the same run. New by default."""
    images: Path | None = None
    """Also write the inputs of the other subcommands to this folder: track/, floor/ with
    survey.json, board/, and calibration.json."""
    out: Path | None = None
    """Folder of the run; runs/locate-DATE-TIME by default."""
    json: bool = False
    """Print one JSON line on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Drive, track, compare with the truth and draw."""
        from circumspect.cli.commands.simulated_space import SIMULATED, SimulatedSpace
        from circumspect.cli.commands.simulated_views import SimulatedViews
        from circumspect.cli.located_run import LocatedRun
        from circumspect.cli.run_screen import new_run_folder

        setup = replace(self.setup, seed=drawn_seed(self.seed))
        views = None if self.images is None else SimulatedViews(self.images)
        with LocatedRun(self.out or new_run_folder("locate"), SIMULATED) as located:
            with flags_named(self, "slip", "ceiling"):
                space = SimulatedSpace.prepared(setup)
            say(f"{setup.cameras} cameras at {setup.ceiling:g} m, seed {setup.seed}")
            if views is None:
                space.drive(say)
            else:
                views.calibration(space)
                space.drive(say, views.save)
            record = space.save(located)
            write_config(located.path, self, "locate simulate", seed=setup.seed)
        print(json.dumps(record) if self.json else _summary(record))  # noqa: T201
        return 0


def _summary(record: dict[str, Any]) -> str:
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
