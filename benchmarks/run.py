"""The whole suite, as `make bench` runs it: one module after the other, on an idle machine."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys

SUITE = ("benchmarks.grid_speed", "benchmarks.classifier_speed")


def main() -> int:
    """Run every module in a process of its own."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    load = os.getloadavg()[0]
    if load > 0.5:
        print(f"note: the machine is busy (load {load:.1f}); the times will be too long")
    return max(subprocess.run([sys.executable, "-m", name]).returncode for name in SUITE)


if __name__ == "__main__":
    sys.exit(main())
