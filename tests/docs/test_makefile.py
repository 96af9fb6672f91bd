"""The commands of `make`, as a dry run or with stand-ins for slow programs."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
STAND_IN = """#!/bin/sh
case "$2" in
  venv) mkdir -p "$3/bin" && cp "$0" "$3/bin/python" && cp "$0" "$3/bin/circumspect" ;;
  pip) for file in $PIP_CONSTRAINT; do cat "$file"; done ;;
esac
"""
"""For python, pip and circumspect; this pip reads its constraints as the true one does."""

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


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


@pytest.mark.parametrize("editable", [False, True])
def test_after_make_dev_only_compiled_files_are_installed_again(
    editable: bool, tmp_path: Path
) -> None:
    venv = tmp_path / ".venv"
    venv.mkdir()
    for name in ("created", "build-tools", "installed-test", *(["editable"] if editable else [])):
        (venv / name).touch()
    make = ["make", "--dry-run", f"VENV={venv}", "test"]

    def printed(*changed: str) -> str:
        words = [*make, *(f"--assume-new={name}" for name in changed)]
        return subprocess.run(words, cwd=REPOSITORY, capture_output=True, text=True).stdout

    assert "pip install" not in printed()
    assert ("pip install" in printed("src/circumspect/errors.py")) is not editable
    changed = "experiments/src/circumspect_experiments/table2.py"
    assert ("pip install" in printed(changed)) is not editable
    compiled = printed("native/trace.cpp")
    assert "--no-build-isolation" in compiled
    assert ("--editable" in compiled) is editable


def test_a_folder_with_a_space_in_its_name_will_do(tmp_path: Path) -> None:
    folder = tmp_path / "my robot"
    for part in ("src/circumspect", "native"):
        (folder / part).mkdir(parents=True)
    for name in ("CMakeLists.txt", "pyproject.toml", "README.md"):
        (folder / name).touch()
    (folder / "constraints.txt").write_text("pinned\n")
    (folder / "python3").write_text(STAND_IN)
    (folder / "python3").chmod(0o755)
    shutil.copy(REPOSITORY / "Makefile", folder)
    make = ["make", "--silent", "PYTHON=./python3", "VENV=.venv", "demo"]
    # Nothing of the make that may have started the tests.
    own = {name: value for name, value in os.environ.items() if "MAKE" not in name}
    made = subprocess.run(make, cwd=folder, env=own, capture_output=True, text=True)
    assert (made.returncode, made.stderr) == (0, "")
    assert made.stdout == 3 * "pinned\n", "pip, build tools and package, each constrained"
    assert (folder / ".venv" / "installed-demo").exists()
