"""Entry point: find the command, parse its flags, run it, turn known faults into one line."""

from __future__ import annotations

import difflib
import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from circumspect import __version__
from circumspect.cli.say import say
from circumspect.cli.termination import EXIT_CODE, Terminated, ends_as_ctrl_c_does
from circumspect.cli.visible_controls import visible_controls
from circumspect.errors import CircumspectError, MissingExtraError, reason_of

COMMANDS = {
    "demo": ("demo:Demo", "a simulated robot drives round an object and names it"),
    "scan": ("scan:Scan", "the same for an object of your choice"),
    "classify": ("classify:Classify", "class and probabilities of meshes, clouds and grids"),
    "explain": ("explain:Explain", "why: the cells that carry the answer, what it resembles"),
    "models": ("models:Models", "the classifiers at hand, with their figures"),
    "teach": ("teach:Teach", "add a class to a classifier from a few examples"),
    "grid": ("grid:Grid", "the occupancy grid of a file, as npz and picture"),
    "replay": ("replay:Replay", "a recording through the pipeline"),
    "watch": ("watch:Watch", "a camera without ROS, live"),
    "gather": ("gather:Gather", "a labelled set: many objects, several starts each"),
    "view": ("view:View", "the dashboard for a finished run, in the browser"),
    "record": ("record:Record", "what a recording holds"),
    "ros2": ("ros2:Ros2", "a ROS 2 node that names what a robot's camera sees"),
    "locate": ("locate:Locate", "the intelligent space: ceiling cameras see the robot"),
    "train": ("train:Train", "train a network"),
    "evaluate": ("evaluate:Evaluate", "accuracy at many yaws, with figures"),
    "calibrate": ("calibrate:Calibrate", "fit when a classifier's answers may be relied on"),
    "export": ("export:Export", "turn a trained network into one ONNX file"),
    "reproduce": ("reproduce:Reproduce", "the paper's table and comparisons, from data to figures"),
    "data": ("data:Data", "fetch, verify and import data sets"),
    "nets": ("nets:Nets", "every network, with its size and work"),
    "doctor": ("doctor:Doctor", "what is installed and what is missing"),
    "completion": ("completion:Completion", "the Tab key completes commands and flags"),
}
PRESETS = {"ros2": "ros2:preset"}
"""Commands whose flags may name a file with values in the place of the defaults."""

HELP = """circumspect: name an object from any side

  circumspect demo                    a simulated robot drives round an object
  circumspect demo --viewer           the same, shown and steered in the browser
  circumspect scan chair.obj          the same for your own mesh
  circumspect classify chair.ply      name the object in a file
  circumspect COMMAND --help          everything about one command
  circumspect doctor                  what is there, what is missing

commands:
{commands}
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: The words after the program's name; None means those of the process.

    Returns:
        Exit code: 0 all done, 1 done and not as it should be (a run without an answer, a check
        that failed), 2 a known fault (already told on standard error), or an answer that could not
        be told, 130 interrupted by Ctrl-C, 143 by SIGTERM.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    # NumPy's matrices are small here: what waits for larger ones takes a core from the network.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _open_closed_streams()
    _escape_what_output_lacks()
    try:
        with ends_as_ctrl_c_does():
            code = _dispatch(words)
            sys.stdout.flush()
            if code == 0 and isinstance(sys.stdout, _ClosedOutput) and sys.stdout.lost:
                raise CircumspectError("standard output is closed, so that nothing could be told")
    except (CircumspectError, KeyboardInterrupt) as error:
        if (interrupt := _interrupt(error)) is not None:
            # A run that was drawn by chance says how it is drawn again.
            notes = getattr(interrupt, "__notes__", ("the same command starts or goes on again",))
            say(f"interrupted; {'; '.join(notes)}")
            return EXIT_CODE if isinstance(interrupt, Terminated) else 130
        say(str(error))
        return 2
    except BrokenPipeError:
        # The reader of our output went away (`| head`); nothing is left to tell it.
        _close_output()
        return 0
    except MemoryError as error:
        # NumPy tells how much was asked for; Python's own error tells nothing.
        say(f"not enough memory ({str(error) or 'nothing is left'}); ask for less at once")
        return 2
    except OSError as error:
        # A path that the system refuses, or a full disk behind standard output.
        if error.filename is None:
            _close_output()
        say(f"{error.filename or 'standard output'}: {reason_of(error)}")
        return 2
    return code


def _interrupt(error: BaseException) -> KeyboardInterrupt | None:
    """What led to it, if that was Ctrl-C: a compiled package that it hits while loading fails to
    import.
    """
    cause: BaseException | None = error
    if isinstance(error, MissingExtraError) and error.__cause__ is not None:
        cause = error.__cause__.__cause__ or error.__cause__.__context__
    return cause if isinstance(cause, KeyboardInterrupt) else None


class _ClosedOutput(io.TextIOWrapper):
    """In the place of a closed standard output: remembers whether something was to be told.

    Work goes on meanwhile, for its files may be all that is wanted.
    """

    lost = False

    def write(self, s: str, /) -> int:
        self.lost = self.lost or bool(s)
        return super().write(s)


def _open_closed_streams() -> None:
    """A job may be started without them (`>&-`); no file of ours shall get their numbers."""
    for name, mode in (("stdin", "rb"), ("stdout", "wb"), ("stderr", "wb")):
        if getattr(sys, name) is None:
            nowhere = Path(os.devnull).open(mode)  # noqa: SIM115
            kind = _ClosedOutput if name == "stdout" else io.TextIOWrapper
            setattr(sys, name, kind(nowhere, encoding="utf-8"))


def _escape_what_output_lacks() -> None:
    """Files may have names, and we signs, that the terminal's encoding can not show."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _close_output() -> None:
    """Let what is still buffered go nowhere when the interpreter ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def _dispatch(words: list[str]) -> int:
    if words[:1] == ["help"] and len(words) > 1:
        words = [words[1], "--help"]
    if not words or words[0] in ("-h", "--help", "help"):
        sys.stdout.write(help_text())
        return 0 if words else 2
    if words[0] in ("--version", "-V"):
        sys.stdout.write(f"circumspect {__version__}\n")
        return 0
    # What is parsed and its help are the user's own and ours; the run prints text of files.
    command = parsed(words[0], words[1:])
    with visible_controls():
        return command.run()


def parsed(name: str, flags: Sequence[str]) -> Any:
    """A command with its flags, ready to run.

    Args:
        name: One of `COMMANDS`.
        flags: The words after it.

    Raises:
        CircumspectError: There is no such command.
        SystemExit: The flags are wrong, or ask for help; it has been told.
    """
    from circumspect.cli.flags import parse

    kind = command(name)
    preset = _named(PRESETS[name])(flags) if name in PRESETS else None
    return parse(kind, f"circumspect {name}", flags, preset)


def command(name: str) -> Any:
    """The data class of a command.

    Raises:
        CircumspectError: There is no such command.
    """
    if name.startswith("-"):
        raise CircumspectError(f"flags come after the command: circumspect COMMAND {name}")
    if name not in COMMANDS:
        near = difflib.get_close_matches(name, COMMANDS, 1)
        hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(COMMANDS)}"
        raise CircumspectError(f"no command '{name}'; {hint}")
    return _named(COMMANDS[name][0])


def _named(place: str) -> Any:
    """What MODULE:NAME tells of this package."""
    module, name = place.split(":")
    return getattr(import_module(f"circumspect.cli.{module}"), name)


def help_text() -> str:
    """What `circumspect --help` prints."""
    lines = (f"  {name:10} {summary}" for name, (_, summary) in COMMANDS.items())
    return HELP.format(commands="\n".join(lines))
