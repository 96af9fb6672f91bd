"""Jobs that nodes of a cluster do in tests."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Nap:
    key: str
    seconds: float
    folder: Path


def sleep(nap: Nap) -> dict[str, Any]:
    """Leaves a file for each time that it is called."""
    (nap.folder / f"{nap.key}.{os.getpid()}.{time.monotonic_ns()}").touch()
    time.sleep(nap.seconds)
    if nap.key == "broken":
        raise ValueError("this one is broken")
    return {"key": nap.key}


def die(nap: Nap) -> dict[str, Any]:
    """The first process that gets a job is lost."""
    first = nap.folder / f"{nap.key}.first"
    if not first.exists():
        first.touch()
        os._exit(1)
    return {"key": nap.key}


def lack_a_module(nap: Nap) -> dict[str, Any]:
    raise ModuleNotFoundError(f"No module named 'circumspect.{nap.key}'")
