"""What `make` would type, without typing it."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
@pytest.mark.parametrize(
    ("target", "extras"),
    [
        ("demo", "sim"),
        ("viewer", "sim,viewer"),
        ("ros2", "ros2"),
        ("test", "test"),
        ("docs", "test"),
    ],
)
def test_a_target_installs_what_it_needs(target: str, extras: str, tmp_path: Path) -> None:
    make = ["make", "--dry-run", "--always-make", f"VENV={tmp_path}/.venv", target]
    script = subprocess.run(make, cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout
    installed = [line for line in script.splitlines() if "pip install" in line and "'." in line]
    assert len(installed) == 1
    assert f"'.[{extras}]'" in installed[0]
    subprocess.run(["sh", "-n"], input=script, text=True, check=True, capture_output=True)
