"""What is freed stays with the process, and comes back without being cleared anew."""

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


def faults(how: str) -> int:
    """Pages that are cleared for an array of 100 MB, the third time it is made."""
    told = subprocess.run(
        [sys.executable, "-c", FAULTS_OF_A_STEP, how], capture_output=True, text=True, check=True
    )
    return int(told.stdout)


@glibc_only
def test_a_large_array_is_made_anew_in_the_same_place() -> None:
    # NumPy asks for huge pages, of which a tenth of a gigabyte has about fifty.
    assert faults("freed") > 20
    assert faults("kept") < 5


def test_other_c_libraries_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platform, "libc_ver", lambda: ("", ""))
    assert not keep_freed_memory()
