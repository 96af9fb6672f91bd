"""Reads mutated files and keeps those that are no known fault."""

from __future__ import annotations

import logging
import random
import resource
import signal
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from tests.fuzz.mutations import mutated
from tests.fuzz.targets import Target

from circumspect.errors import CircumspectError

MOST_SECONDS = 20
"""Of one file of at most a megabyte."""
MOST_MEMORY = 1 << 30
"""That the process may grow by while it reads files [bytes]."""


class HangError(Exception):
    """A file took too long."""


@dataclass
class Findings:
    """What came of a target.

    Attributes:
        inputs: How many files were read.
        refused: Known faults among them.
        faults: Where in the code other exceptions came up, and how often.
        kept: A file for each of these places.
        grown: By how much the memory of the process grew at most [bytes].
    """

    inputs: int = 0
    refused: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    kept: dict[str, Path] = field(default_factory=dict)
    grown: int = 0

    @property
    def clean(self) -> bool:
        """Whether nothing was found."""
        return not self.faults and self.grown < MOST_MEMORY


def fuzz(target: Target, folder: Path, seconds: float, seed: int, most: int = 10**9) -> Findings:
    """Read mutated files for a while.

    Args:
        target: What reads them.
        folder: Takes the files; those that show something stay.
        seconds: How long.
        seed: Of the mutations.
        most: Files at most.
    """
    rng, found = random.Random(seed), Findings()
    source = folder / "seeds"
    source.mkdir(parents=True)
    seeds = [(path.name, path.read_bytes()) for path in target.seeds(source)]
    for name, content in seeds:
        path = folder / (target.place or name)
        path.write_bytes(content)
        _read(target, path, Findings(), folder)
    logging.disable(logging.CRITICAL)
    before, end = _peak(), time.monotonic() + seconds
    try:
        while found.inputs < most and time.monotonic() < end:
            (name, content), (_, other) = rng.choice(seeds), rng.choice(seeds)
            path = folder / (target.place or f"x{Path(name).suffix}")
            path.write_bytes(mutated(content, other, rng))
            _read(target, path, found, folder)
    finally:
        logging.disable(logging.NOTSET)
    found.grown = _peak() - before
    return found


def _read(target: Target, path: Path, found: Findings, folder: Path) -> None:
    found.inputs += 1
    handler = signal.signal(signal.SIGALRM, _hang)
    signal.alarm(MOST_SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            target.read(path)
    except CircumspectError:
        found.refused += 1
    except Exception as error:  # what is looked for
        place = traceback.extract_tb(error.__traceback__)[-1]
        key = f"{type(error).__name__} at {Path(place.filename).name}:{place.lineno}"
        found.faults[key] += 1
        if key not in found.kept:
            found.kept[key] = folder / f"found-{len(found.kept)}{path.suffix}"
            found.kept[key].write_bytes(path.read_bytes())
            found.kept[key].with_suffix(".txt").write_text(traceback.format_exc())
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)


def _hang(_: int, __: FrameType | None) -> None:
    raise HangError


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss << 10
