"""`circumspect demo`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.errors import InputError

FRAME_INTERVAL = 1.0
"""Between frames [s]: one each 5 cm instead of the paper's 2.5 cm, so that nobody has to wait."""


@dataclass(frozen=True)
class Demo:
    """A simulated robot drives round a piece of furniture and names it.

    $ circumspect demo
    $ circumspect demo --viewer
    $ circumspect demo --object chair --start 135
    $ circumspect demo --seed 7 --out runs/seven

    The same as `circumspect scan` with a frame each 5 cm.
    """

    object: str | None = None
    """bathtub, bed, chair, desk, dresser, monitor, night_stand, sofa, table or toilet; without it
    one is drawn."""
    start: float | None = None
    """Azimuth of the start [degrees], counter-clockwise seen from above; without it drawn."""
    seed: int | None = None
    """The same seed gives the same object, start and noise; without it a new one is drawn."""
    frames: int = 1000
    """The run ends after so many frames."""
    out: Path | None = None
    """Folder of the run; runs/demo-DATE-TIME by default."""
    model: ModelFlag = ROBOT
    """A shipped classifier (`circumspect models` lists them), or an ONNX file of your own that
    `circumspect export` made."""
    record: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Record what the robot sees and says into a new MCAP file."""
    viewer: bool = False
    """Show the run in the browser, where it can be steered; the page stays when the run is over."""
    page: Annotated[PageFlags, tyro.conf.arg(name="")] = field(default_factory=PageFlags)
    """Where the dashboard is shown."""
    json: bool = False
    """One JSON line on standard output and nothing else there."""

    def run(self) -> int:
        """Drive, model, name, save."""
        from circumspect.cli.scan import Scan, drawn_seed

        seed = drawn_seed(self.seed)
        scan = Scan(
            object=self._drawn(seed),
            start=self.start,
            seed=seed,
            frame_interval=FRAME_INTERVAL,
            frames=self.frames,
            out=self.out,
            model=self.model,
            record=self.record,
            viewer=self.viewer,
            page=self.page,
            json=self.json,
        )
        return scan.run("demo")

    def _drawn(self, seed: int) -> str:
        import numpy as np

        from circumspect.furniture import CATEGORIES

        category = str(np.random.default_rng([seed, 1]).choice(CATEGORIES))
        if self.object is None:
            return category
        if self.object.rpartition("-")[0] in CATEGORIES or self.object in CATEGORIES:
            return self.object
        raise InputError(f"no object {self.object!r}; known: {', '.join(CATEGORIES)}")
