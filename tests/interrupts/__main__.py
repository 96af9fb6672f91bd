"""`python -m tests.interrupts --points N`: exit code 1 where something was found."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1]))

from tests.interrupts.harness import ENDS, faults, run
from tests.tiny_commands import TinyInputs, command_words


def main() -> int:
    """Interrupt commands at evenly spaced moments, and print what came of it."""
    names = [" ".join(words) for words in command_words()]
    parser = argparse.ArgumentParser(prog="python -m tests.interrupts", description=__doc__)
    parser.add_argument("commands", nargs="*", help=f"of: {', '.join(names)}; all by default")
    parser.add_argument("--points", type=int, default=40, help="moments of each command")
    parser.add_argument("--seconds", type=float, default=1e9, help="no command begins after it")
    flags = parser.parse_args()
    # In the background of a shell it is ignored, which the commands would inherit.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    folder, begin, clean = Path(tempfile.mkdtemp(prefix="interrupts-")), time.monotonic(), True
    os.environ["CIRCUMSPECT_CACHE"] = str(folder / "cache")
    os.environ["CIRCUMSPECT_MODELS"] = str(folder / "models")
    (folder / "inputs").mkdir()
    inputs = TinyInputs(folder / "inputs")
    for name in flags.commands or names:
        if time.monotonic() - begin < flags.seconds:
            clean &= interrupted(name, inputs, folder, flags.points)
    return 0 if clean else 1


def interrupted(name: str, inputs: TinyInputs, folder: Path, points: int) -> bool:
    """Interrupt one command; whether all went well."""
    command, home = tuple(name.split()), folder / name.replace(" ", "-")
    place = home / "whole"
    place.mkdir(parents=True)
    whole = run(inputs.words(command, place))
    found: list[str] = []
    if whole.code not in (0, 1):
        found.append(f"by itself: exit code {whole.code}: {whole.err}")
    stopped = 0
    for point in range(points):
        place, delay = home / str(point), whole.seconds * (point + 0.5) / points
        place.mkdir()
        ended = run(inputs.words(command, place), delay)
        stopped += ended.code in ENDS
        wrong = faults(ended, place, whole.code)
        found += [f"after {delay:.2f} s: {fault}\n{ended.err[-2000:]}" for fault in wrong]
    print(
        f"{name}: {whole.seconds:.1f} s, {points} moments, {stopped} ended it, {len(found)} faults",
        flush=True,
    )
    for fault in found:
        print(f"  {fault}", flush=True)
    return not found


if __name__ == "__main__":
    sys.exit(main())
