"""Runs a command, presses Ctrl-C at a moment, and looks at what is left."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import zipfile
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

PROGRAM = """
import os, sys
os.write({ready}, b"x")
from circumspect.cli.entry import entry
sys.exit(entry())
"""
"""What the installed script does, which says first that Python has started."""
ENDS = (130, -signal.SIGINT)
"""Both are 130 to a shell; the second is Python's own end, behind the command."""
LONGEST = 20.0
"""Longest time from Ctrl-C to the end of a command [s]."""


@dataclass(frozen=True)
class Ended:
    """How a command ended.

    Attributes:
        code: Exit code; negative for a signal.
        out: Standard output.
        err: Standard error.
        seconds: From its start, or from Ctrl-C where it was pressed.
    """

    code: int
    out: str
    err: str
    seconds: float


def run(words: tuple[str, ...], delay: float | None = None, longest: float = 600.0) -> Ended:
    """Run a command.

    Args:
        words: Its words and flags.
        delay: When Ctrl-C is pressed after Python has started [s]; None for never.
        longest: When it is given up [s].
    """
    reading, ready = os.pipe()
    program = PROGRAM.format(ready=ready)
    process = subprocess.Popen(
        [sys.executable, "-c", program, *words], pass_fds=(ready,), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    os.close(ready)
    try:
        os.read(reading, 1)
        begin = time.monotonic()
        if delay is not None:
            try:
                out, err = process.communicate(timeout=max(delay, 1e-4))
            except subprocess.TimeoutExpired:
                begin = time.monotonic()
                # As a terminal does: the workers get it, too.
                os.killpg(process.pid, signal.SIGINT)
                out, err = process.communicate(timeout=longest)
        else:
            out, err = process.communicate(timeout=longest)
    finally:
        os.close(reading)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    return Ended(process.returncode, out, err, time.monotonic() - begin)


def faults(ended: Ended, out: Path, whole: int) -> list[str]:
    """What is wrong with how an interrupted command ended, and with what it left.

    Args:
        ended: How it ended.
        out: Where its results go.
        whole: Its exit code where nobody interrupts it.
    """
    found = []
    if ended.code not in (*ENDS, whole):
        found.append(f"exit code {ended.code}")
    if ended.code == ENDS[0] and "interrupted" not in ended.err:
        found.append("no word of it")
    if "Traceback" in ended.err or "Error" in ended.err:
        found.append("a traceback")
    if ended.seconds > LONGEST and ended.code in ENDS:
        found.append(f"Ctrl-C took {ended.seconds:.0f} s")
    for path in sorted(out.rglob("*")):
        if path.is_file() and (why := cut(path)) is not None:
            found.append(f"{path.relative_to(out)}: {why}")
    return found


def cut(path: Path) -> str | None:
    """Why a file is not whole; None where it is."""
    if "-partial-" in path.name:
        return "is left over"
    try:
        _read(path)
    except Exception as error:  # any error of a truncated file
        return f"{type(error).__name__}: {error}"[:200]
    return None


def _read(path: Path) -> None:
    if path.suffix == ".json":
        json.loads(path.read_text())
    elif path.suffix == ".jsonl":
        for line in path.read_text().splitlines():
            json.loads(line)
    elif path.suffix in (".npz", ".zip"):
        with zipfile.ZipFile(path) as archive:
            if (name := archive.testzip()) is not None:
                raise ValueError(f"{name} is broken")
    elif path.suffix in (".png", ".jpg"):
        with Image.open(path) as picture:
            picture.load()
    elif path.suffix == ".mcap":
        from circumspect.recording import open_bag

        if (fault := open_bag(path).fault) is not None:
            raise ValueError(fault)
    elif path.suffix == ".onnx":
        from circumspect.classification import Classifier

        Classifier.load(path)
    elif path.suffix == ".safetensors":
        from safetensors import safe_open

        with safe_open(path, "numpy") as tensors:
            for name in tensors.keys():  # noqa: SIM118
                tensors.get_tensor(name)
    elif path.suffix == ".ply":
        from circumspect.geometry import read_cloud

        read_cloud(path)
