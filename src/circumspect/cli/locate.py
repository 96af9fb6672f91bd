"""`circumspect locate`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from circumspect.cli.locate_board import Board
from circumspect.cli.locate_extrinsics import Extrinsics
from circumspect.cli.locate_intrinsics import Intrinsics
from circumspect.cli.locate_simulate import Simulate
from circumspect.cli.locate_track import Track


@dataclass(frozen=True)
class Locate:
    """Ceiling cameras see a tag on the robot and say where it is.

    $ circumspect locate simulate
    $ circumspect locate board --out print
    $ circumspect locate intrinsics board-images/ceiling_0 --out calibration.json
    $ circumspect locate extrinsics floor/ceiling_0 --survey survey.json
          --intrinsics calibration.json --out calibration.json
    $ circumspect locate track images --calibration calibration.json
    """

    what: Annotated[
        Annotated[Simulate, tyro.conf.subcommand("simulate")]
        | Annotated[Board, tyro.conf.subcommand("board")]
        | Annotated[Intrinsics, tyro.conf.subcommand("intrinsics")]
        | Annotated[Extrinsics, tyro.conf.subcommand("extrinsics")]
        | Annotated[Track, tyro.conf.subcommand("track")],
        tyro.conf.OmitArgPrefixes,
        tyro.conf.OmitSubcommandPrefixes,
    ]

    def run(self) -> int:
        """Whatever was asked for."""
        return self.what.run()
