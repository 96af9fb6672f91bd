"""Entry point: find the command, parse its flags, run it, print known errors as one line."""

from __future__ import annotations

import difflib
import io
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

from circumspect import __version__
from circumspect.cli.say import say
from circumspect.cli.visible_controls import visible_controls
from circumspect.errors import CircumspectError, MissingExtraError, reason_of

EXPERIMENTS = "circumspect_experiments"
"""Package of the experiments; a robot does not need it."""
COMMANDS = {
    "demo": ("demo:Demo", "let a simulated robot drive round an object and classify it"),
    "scan": ("scan:Scan", "the same for an object of your choice"),
    "classify": ("classify:Classify", "classify meshes, point clouds and grids in files"),
    "explain": ("explain:Explain", "show the cells and training objects behind an answer"),
    "models": ("models:Models", "list classifiers with their measured accuracy"),
    "teach": ("teach:Teach", "add a class to a classifier from a few examples"),
    "grid": ("grid:Grid", "compute the occupancy grid of a file, as npz and picture"),
    "replay": ("replay:Replay", "run the pipeline on a recording"),
    "watch": ("watch:Watch", "run the pipeline live on a camera, without ROS"),
    "gather": ("gather:Gather", "make a labelled set of scans, simulated or recorded"),
    "view": ("view:View", "play a finished run in the browser"),
    "record": ("record:Record", "show the contents of a recording"),
    "ros2": ("ros2:Ros2", "run a ROS 2 node that classifies objects seen by a robot"),
    "locate": ("locate:Locate", "locate the robot by ceiling cameras (intelligent space)"),
    "train": ("train:Train", "train a network"),
    "evaluate": ("evaluate:Evaluate", "measure the accuracy at many yaws, with figures"),
    "calibrate": ("calibrate:Calibrate", "fit temperature and confidence bounds of a classifier"),
    "export": ("export:Export", "export trained networks as one ONNX file"),
    "reproduce": (
        "circumspect_experiments.reproduce_command:Reproduce",
        "reproduce the paper's table and comparisons with others",
    ),
    "data": ("data:Data", "fetch, verify, import and convert data sets"),
    "nets": ("nets:Nets", "list all networks with parameters and multiply-adds"),
    "doctor": ("doctor:Doctor", "check the installation and list missing extras"),
    "completion": ("completion:Completion", "print a completion script for your shell"),
}
PRESETS = {"ros2": "ros2:preset"}
"""Commands with a flag for another kind of file with values of flags than `--config`."""

HELP = """circumspect: name an object from any side

  circumspect demo                    a simulated robot drives round an object
  circumspect demo --viewer           the same, with a dashboard in the browser
  circumspect scan chair.obj          the same for your own mesh
  circumspect classify chair.ply      classify the object in a file
  circumspect COMMAND --help          help and examples of a command
  circumspect doctor                  check the installation

commands:
{commands}
"""
EXIT_CODE = 128 + signal.SIGTERM
"""Exit code of a program ended by the signal, as in shells."""


class Terminated(KeyboardInterrupt):
    """SIGTERM was received: results so far are saved, a driving robot is stopped."""


@contextmanager
def ends_as_ctrl_c_does() -> Iterator[None]:
    """Raise `Terminated` in the main thread on SIGTERM, if the signal has its default action.

    Another handler is kept, and an ignored signal stays ignored.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGTERM, _raise)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _raise(*_: object) -> NoReturn:
    raise Terminated


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: The words after the name of the program; None means those of the process.

    Returns:
        Exit code: 0 done; 1 done, but a run has no answer or a check failed; 2 a known error
        (already printed on standard error), or an answer that can not be printed; 130 interrupted
        by Ctrl-C; 143 by SIGTERM.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    # NumPy's matrices are small here: idle threads of OpenBLAS take a core from the network.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _replace_closed_streams()
    _escape_unencodable_characters()
    try:
        with ends_as_ctrl_c_does():
            code = _dispatch(words)
            sys.stdout.flush()
            if code == 0 and isinstance(sys.stdout, _ClosedOutput) and sys.stdout.lost:
                raise CircumspectError("standard output is closed; nothing could be printed")
    except (CircumspectError, KeyboardInterrupt) as error:
        if (interrupt := _interrupt_behind(error)) is not None:
            # A run with random values adds a note how to repeat it.
            notes = getattr(interrupt, "__notes__", ("the same command starts or resumes it",))
            say(f"interrupted; {'; '.join(notes)}")
            return EXIT_CODE if isinstance(interrupt, Terminated) else 130
        say(str(error))
        return 2
    except BrokenPipeError:
        # The reader of standard output has closed the pipe (`| head`).
        _close_output()
        return 0
    except MemoryError as error:
        # Only NumPy's errors state the requested size.
        say(f"not enough memory ({str(error) or 'nothing is left'}); request less at once")
        return 2
    except OSError as error:
        # The system rejects a path, or the disk behind standard output is full.
        if error.filename is None:
            _close_output()
        say(f"{error.filename or 'standard output'}: {reason_of(error)}")
        return 2
    return code


def _interrupt_behind(error: BaseException) -> KeyboardInterrupt | None:
    """The `KeyboardInterrupt` that caused an error, if any.

    A compiled package that is interrupted while it loads fails to import.
    """
    cause: BaseException | None = error
    if isinstance(error, MissingExtraError) and error.__cause__ is not None:
        cause = error.__cause__.__cause__ or error.__cause__.__context__
    return cause if isinstance(cause, KeyboardInterrupt) else None


class _ClosedOutput(io.TextIOWrapper):
    """Replaces a closed standard output; `lost` is set if something is printed.

    The command continues, because its files may be sufficient.
    """

    lost = False

    def write(self, s: str, /) -> int:
        self.lost = self.lost or bool(s)
        return super().write(s)


def _replace_closed_streams() -> None:
    """Replace closed streams (`>&-`), so that no opened file gets their descriptors."""
    for name, mode in (("stdin", "rb"), ("stdout", "wb"), ("stderr", "wb")):
        if getattr(sys, name) is None:
            nowhere = Path(os.devnull).open(mode)  # noqa: SIM115
            kind = _ClosedOutput if name == "stdout" else io.TextIOWrapper
            setattr(sys, name, kind(nowhere, encoding="utf-8"))


def _escape_unencodable_characters() -> None:
    """Escape characters that the encoding of the terminal lacks, as in names of files."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _close_output() -> None:
    """Discard buffered output when the interpreter ends."""
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
    # Parsing prints only trusted text; the run prints text of files.
    command = parsed(words[0], words[1:])
    with visible_controls():
        return command.run()


def parsed(name: str, flags: Sequence[str]) -> Any:
    """Parse the flags of a command.

    Args:
        name: One of `COMMANDS`.
        flags: The words after it.

    Raises:
        CircumspectError: There is no such command, or a file with values of flags is wrong.
        SystemExit: The flags are wrong, or request help; the message is printed.
    """
    from circumspect.cli.flags import parse

    kind = command(name)
    # The first word selects the subcommand of a command that has some.
    target = getattr(kind, "COMMANDS", {}).get(flags[0] if flags else None, kind)
    values: dict[str, Any] = {}
    if any(word.startswith("--config") for word in flags):
        from circumspect.cli.config_file import values_of_files

        values = values_of_files(target, flags)
    if name in PRESETS:
        values = _imported(PRESETS[name])(flags, values)
    return parse(kind, f"circumspect {name}", flags, {target: values})


def command(name: str) -> Any:
    """The data class of a command.

    Raises:
        CircumspectError: There is no such command.
    """
    if name.startswith("-"):
        raise CircumspectError(f"flags come after the command: circumspect COMMAND {name}")
    if name not in COMMANDS:
        near = difflib.get_close_matches(name, COMMANDS, 1)
        hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(installed_commands())}"
        raise CircumspectError(f"no command '{name}'; {hint}")
    return _imported(COMMANDS[name][0])


def installed_commands() -> dict[str, str]:
    """Name and summary of every command whose package is installed."""
    return {
        name: summary
        for name, (place, summary) in COMMANDS.items()
        if not place.startswith(EXPERIMENTS) or find_spec(EXPERIMENTS) is not None
    }


def _imported(place: str) -> Any:
    """The object MODULE:NAME of `circumspect.cli.commands`, or of the experiments.

    Raises:
        CircumspectError: The package of the experiments is not installed.
    """
    module, name = place.split(":")
    if not module.startswith(EXPERIMENTS):
        return getattr(import_module(f"circumspect.cli.commands.{module}"), name)
    if find_spec(EXPERIMENTS) is None:
        raise CircumspectError(
            "this command is in the package circumspect-experiments, which is not installed; "
            "in the repository: pip install ./experiments"
        )
    return getattr(import_module(module), name)


def help_text() -> str:
    """The text of `circumspect --help`."""
    lines = (f"  {name:10} {summary}" for name, summary in installed_commands().items())
    return HELP.format(commands="\n".join(lines))
