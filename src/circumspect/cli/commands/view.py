"""`circumspect view RUN`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from circumspect.cli.dashboard_page import PageFlags
from circumspect.cli.model_flag import ROBOT, ModelFlag

if TYPE_CHECKING:
    from circumspect.viewer import PlayedRun


@dataclass(frozen=True)
class View:
    """Play a finished run in the browser, or export it as one HTML file.

    $ circumspect view runs/demo-20260101-120000
    $ circumspect view runs/demo-20260101-120000 --export demo.html
    """

    run_folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")]
    """Folder of a run of `circumspect demo`, `scan` or `replay`."""
    export: Annotated[Path | None, tyro.conf.arg(metavar="FILE.html")] = None
    """Write one HTML file and exit. It plays the run offline, without this program."""
    model: ModelFlag = ROBOT
    """Classifier for the object that you turn in the browser: a shipped one (`circumspect models`
    lists them), or your own ONNX file written by `circumspect export`."""
    page: PageFlags = field(default_factory=PageFlags)
    """Address of the dashboard."""

    def run(self) -> int:
        """Show the run until Ctrl-C, or export it."""
        from circumspect.classification import Classifier
        from circumspect.cli.dashboard_page import stay
        from circumspect.cli.say import say
        from circumspect.errors import InputError
        from circumspect.viewer import PlayedRun, Player, SavedRun

        saved = SavedRun.load(self.run_folder)
        if not saved.rows:
            raise InputError(f"{self.run_folder}: the run has no frames; nothing can be shown")
        for reason in saved.missing:
            say(reason)
        played = PlayedRun(saved)
        if self.export is not None:
            return self._exported(played, self.export)
        classifier = Classifier.load(self.model)
        try:
            with self.page.opened(classifier) as dashboard:
                player = Player(played, dashboard)
                try:
                    stay()
                finally:
                    player.close()
        except KeyboardInterrupt:
            say("the dashboard is closed")
        return 0

    def _exported(self, played: PlayedRun, file: Path) -> int:
        from circumspect.errors import printable
        from circumspect.viewer.html_export import export_html

        size = export_html(played, file)
        print(f"{printable(str(file))}: {size / 1e6:.1f} MB, opens in any browser")  # noqa: T201
        return 0
