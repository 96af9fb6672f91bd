"""`circumspect locate`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import tyro

from circumspect.cli.flags import described
from circumspect.cli.locate_board import Board
from circumspect.cli.locate_extrinsics import Extrinsics
from circumspect.cli.locate_intrinsics import Intrinsics
from circumspect.cli.locate_simulate import Simulate
from circumspect.cli.locate_track import Track


def _subcommand(name: str, kind: Any) -> Any:
    return tyro.conf.subcommand(name, description=described(kind))


@dataclass(frozen=True)
class Locate:
    r"""Ceiling cameras see a tag on the robot and say where it is.

    $ circumspect locate simulate
    $ circumspect locate board --out print
    $ circumspect locate intrinsics board-images/ceiling_0 --out calibration.json
    $ circumspect locate extrinsics floor/ceiling_0 \
          --survey survey.json --intrinsics calibration.json \
          --out calibration.json
    $ circumspect locate track images --calibration calibration.json
    """

    what: Annotated[
        Annotated[Simulate, _subcommand("simulate", Simulate)]
        | Annotated[Board, _subcommand("board", Board)]
        | Annotated[Intrinsics, _subcommand("intrinsics", Intrinsics)]
        | Annotated[Extrinsics, _subcommand("extrinsics", Extrinsics)]
        | Annotated[Track, _subcommand("track", Track)],
        tyro.conf.OmitArgPrefixes,
        tyro.conf.OmitSubcommandPrefixes,
    ]

    def run(self) -> int:
        """Whatever was asked for."""
        return self.what.run()
