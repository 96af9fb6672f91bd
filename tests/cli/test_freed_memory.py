"""Freed memory stays with the process and is used again without being cleared."""

from __future__ import annotations

import platform
import subprocess
import sys

import pytest

from circumspect.cli.freed_memory import keep_freed_memory

FAULTS_OF_A_STEP = """
import resource, sys
import numpy as np
from circumspect.cli.freed_memory import keep_freed_memory
if sys.argv[1] == "kept":
    assert keep_freed_memory()
for step in range(3):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    np.ones(100_000_000 // 8)
    faults = resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
print(faults)
"""

glibc_only = pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc", reason="another C library than glibc"
)


def faults(mode: str) -> int:
    """Page faults of the third allocation of 100 MB."""
    child = subprocess.run(
        [sys.executable, "-c", FAULTS_OF_A_STEP, mode], capture_output=True, text=True, check=True
    )
    return int(child.stdout)


@glibc_only
def test_a_large_array_reuses_freed_memory() -> None:
    # NumPy asks for huge pages; 100 MB have about fifty.
    assert faults("freed") > 20
    assert faults("kept") < 5


def test_other_c_libraries_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platform, "libc_ver", lambda: ("", ""))
    assert not keep_freed_memory()
