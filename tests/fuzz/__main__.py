"""`python -m tests.fuzz TARGET --seconds N`: exit code 1 where something was found."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from tests.fuzz.fuzzer import fuzz
from tests.fuzz.targets import TARGETS


def main() -> int:
    """Fuzz one target or all, and print what came of it."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("target", choices=[*TARGETS, "all"])
    parser.add_argument("--seconds", type=float, default=60.0, help="for each target")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="keeps what was found; a new folder by default")
    flags = parser.parse_args()
    out, clean = flags.out or Path(tempfile.mkdtemp(prefix="fuzz-")), True
    for name in TARGETS if flags.target == "all" else [flags.target]:
        found = fuzz(TARGETS[name], out / name, flags.seconds, flags.seed)
        clean &= found.clean
        print(
            f"{name}: {found.inputs} inputs, {found.refused} refused, "
            f"{sum(found.faults.values())} faults, memory grew by {found.grown >> 20} MiB"
        )
        for fault, count in found.faults.most_common():
            print(f"  {count:6} {fault}: {found.kept[fault]}")
    return 0 if clean else 1


if __name__ == "__main__":
    sys.exit(main())
