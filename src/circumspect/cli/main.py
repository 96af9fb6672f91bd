"""Entry point: parse, run the chosen command, turn known faults into one line."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import tyro

from circumspect.cli.classify import Classify
from circumspect.cli.doctor import Doctor
from circumspect.cli.evaluate import Evaluate
from circumspect.cli.export import Export
from circumspect.cli.grid import Grid
from circumspect.cli.nets import Nets
from circumspect.cli.train import Train
from circumspect.errors import CircumspectError

COMMANDS = {
    "classify": Classify,
    "grid": Grid,
    "train": Train,
    "evaluate": Evaluate,
    "export": Export,
    "nets": Nets,
    "doctor": Doctor,
}

DESCRIPTION = """Name an object from any side.

  circumspect demo                 a simulated camera circles an object and names it
  circumspect classify chair.ply   class and probabilities of a mesh, cloud or grid
  circumspect COMMAND --help       everything about one command
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: The words after the program's name; None means those of the process.

    Returns:
        Exit code: 0 all done, 2 a known fault (already told on standard error), 130 interrupted.
    """
    command = tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="circumspect",
        description=DESCRIPTION,
        args=None if arguments is None else list(arguments),
        config=(tyro.conf.OmitArgPrefixes,),
    )
    try:
        return command.run()
    except CircumspectError as error:
        print(f"circumspect: {error}", file=sys.stderr)  # noqa: T201
        return 2
    except KeyboardInterrupt:
        print("circumspect: interrupted", file=sys.stderr)  # noqa: T201
        return 130
    except BrokenPipeError:
        # The reader of our output went away (`| head`); nothing is left to tell it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


if __name__ == "__main__":
    sys.exit(main())
