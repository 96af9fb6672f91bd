"""`circumspect demo`."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from circumspect.cli.config_file import ConfigFlag
from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.flag_table import Flags
from circumspect.cli.given_flags import drawn_seed
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.errors import InputError
from circumspect.exploration.scan_settings import ScanSettings

if TYPE_CHECKING:
    from circumspect.cli.commands.scan import Scan

FRAME_INTERVAL = 1.0
"""Interval between frames [s]: one per 5 cm instead of the paper's 2.5 cm, for a short run."""


@dataclass(frozen=True)
class Demo:
    """Let a simulated robot drive round a piece of furniture and classify it.

    $ circumspect demo
    $ circumspect demo --viewer
    $ circumspect demo --object chair --start 135
    $ circumspect demo --seed 7 --out runs/seven

    Same as `circumspect scan`, with one frame per 5 cm.
    """

    object: str | None = None
    """bathtub, bed, chair, desk, dresser, monitor, night_stand, sofa, table or toilet; random by
    default."""
    start: float | None = None
    """Azimuth of the start [degrees], counter-clockwise from above; random by default."""
    seed: int | None = None
    """Random seed; the same seed gives the same object, start and noise. New by default."""
    driving: Annotated[ScanSettings, Flags(max_frames="frames")] = field(
        default_factory=lambda: ScanSettings(frame_interval=FRAME_INTERVAL, max_frames=1000)
    )
    """Driving and camera frames."""
    out: Path | None = None
    """Folder of the run; runs/demo-DATE-TIME by default."""
    model: ModelFlag = ROBOT
    """Shipped classifier (`circumspect models` lists them), or your own ONNX file written by
    `circumspect export`."""
    record: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Record sensor data and answers in a new MCAP file."""
    viewer: bool = False
    """Show and control the run in the browser; the page stays open after the run."""
    page: PageFlags = field(default_factory=PageFlags)
    """Address of the dashboard."""
    json: bool = False
    """Print one JSON line on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Drive, map, classify, save."""
        seed = drawn_seed(self.seed)
        given = replace(self, seed=seed, object=self._drawn(seed))
        return given.scan().run("demo", given)

    def scan(self) -> Scan:
        """The equivalent `Scan`; object and seed must be set."""
        from circumspect.cli.commands.scan import Scan

        own = [one.name for one in fields(self) if one.name != "config"]
        return Scan(**{name: getattr(self, name) for name in own})

    def _drawn(self, seed: int) -> str:
        import numpy as np

        from circumspect.furniture import CATEGORIES

        category = str(np.random.default_rng([seed, 1]).choice(CATEGORIES))
        if self.object is None:
            return category
        if self.object.rpartition("-")[0] in CATEGORIES or self.object in CATEGORIES:
            return self.object
        raise InputError(f"no object {self.object!r}; known: {', '.join(CATEGORIES)}")
