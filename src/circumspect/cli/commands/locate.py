"""`circumspect locate`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Union

import tyro

from circumspect.cli.commands.locate_board import Board
from circumspect.cli.commands.locate_extrinsics import Extrinsics
from circumspect.cli.commands.locate_intrinsics import Intrinsics
from circumspect.cli.commands.locate_simulate import Simulate
from circumspect.cli.commands.locate_track import Track
from circumspect.cli.flags import described

COMMANDS = {
    "simulate": Simulate,
    "board": Board,
    "intrinsics": Intrinsics,
    "extrinsics": Extrinsics,
    "track": Track,
}
if TYPE_CHECKING:
    AnyCommand = Simulate | Board | Intrinsics | Extrinsics | Track
else:
    AnyCommand = Union[  # noqa: UP007 - put together at run time
        tuple(
            Annotated[kind, tyro.conf.subcommand(name, description=described(kind))]
            for name, kind in COMMANDS.items()
        )
    ]


@dataclass(frozen=True)
class Locate:
    r"""Locate the robot by ceiling cameras that detect a tag on it.

    $ circumspect locate simulate
    $ circumspect locate board --out print
    $ circumspect locate intrinsics board-images/ceiling_0 --out calibration.json
    $ circumspect locate extrinsics floor/ceiling_0 \
          --survey survey.json --intrinsics calibration.json \
          --out calibration.json
    $ circumspect locate track images --calibration calibration.json
    """

    COMMANDS: ClassVar = COMMANDS
    what: Annotated[AnyCommand, tyro.conf.OmitArgPrefixes, tyro.conf.OmitSubcommandPrefixes]

    def run(self) -> int:
        """Run the subcommand."""
        return self.what.run()
