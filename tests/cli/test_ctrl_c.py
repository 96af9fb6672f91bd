"""Ctrl-C at any moment: one line at most, never a traceback."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import circumspect

# Raises the signal at the n-th call of a function, so that the moment is not one of the clock.
PROGRAM = """
import signal, sys
from circumspect.cli.entry import entry
moment, count = float(sys.argv.pop(1)), 0
def profile(frame, event, argument):
    global count
    count += 1
    if count == moment:
        sys.setprofile(None)
        signal.raise_signal(signal.SIGINT)
sys.setprofile(profile)
try:
    sys.exit(entry())
finally:
    sys.setprofile(None)
    if moment == float("inf"):
        print(count)
"""


def run(moment: float, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, str(moment), *words],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cloud") / "a.npy"
    np.save(path, np.random.default_rng(0).random((500, 3)))
    return path


@pytest.mark.parametrize("command", ["nets --help", "grid"])
def test_no_traceback_at_any_moment(command: str, cloud: Path, tmp_path: Path) -> None:
    words = command.split()
    if command == "grid":
        words += [str(cloud), "--out", str(tmp_path / "grid.npz")]
    whole = run(float("inf"), *words)
    assert whole.returncode == 0, whole.stderr
    calls = int(whole.stdout.splitlines()[-1])
    for share in (0.0, 0.3, 0.6, 0.9):
        found = run(1 + int(share * (calls - 1)), *words)
        assert "Traceback" not in found.stderr, f"at {share:.0%}: {found.stderr}"
        assert found.stderr.count("\n") <= 1, found.stderr
        # A handler of C may postpone it until all is done.
        assert found.returncode in (130, 0, -signal.SIGINT), f"at {share:.0%}: {found.stderr}"


def test_after_the_end_of_a_command_ctrl_c_ends_python_silently() -> None:
    program = (
        "import signal, sys\n"
        "from circumspect.cli.entry import entry\n"
        "sys.argv[1:] = ['--version']\n"
        "entry()\n"
        "signal.raise_signal(signal.SIGINT)\n"
    )
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert found.returncode == -signal.SIGINT
    assert found.stderr == ""


def test_nothing_is_imported_before_ctrl_c_ends_silently() -> None:
    """A module imported earlier shows a traceback if Ctrl-C comes during its import."""
    program = (
        "import sys\n"
        "plain, found = sys.excepthook, []\n"
        "class Finder:\n"
        "    def find_spec(self, name, *_):\n"
        "        if sys.excepthook is plain: found.append(name)\n"
        "sys.meta_path.insert(0, Finder())\n"
        "import circumspect.cli.entry\n"
        "print(*found)\n"
    )
    # Without `site`, which imports more by itself, only the path says where the package is.
    environment = {**os.environ, "PYTHONPATH": str(Path(circumspect.__file__).parents[1])}
    command = [sys.executable, "-S", "-c", program]
    found = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert found.returncode == 0, found.stderr
    names = [name for name in found.stdout.split() if name != "__future__"]
    assert names == ["circumspect", "circumspect.cli", "circumspect.cli.entry"]


def test_an_interrupt_in_a_finalizer_is_not_lost() -> None:
    program = (
        "import signal, sys\n"
        "import circumspect.cli.main as main, circumspect.cli.entry as entry\n"
        "class Late:\n"
        "    def __del__(self):\n"
        "        signal.raise_signal(signal.SIGINT)\n"
        "def run():\n"
        "    late = Late()\n"
        "    del late\n"
        "    while True: pass\n"
        "main.main = run\n"
        "sys.exit(entry.entry())\n"
    )
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60
    )
    assert found.returncode == 130
    assert found.stderr.startswith("circumspect: interrupted")
    assert found.stderr.count("\n") == 1


def test_an_ignored_ctrl_c_stays_ignored() -> None:
    program = (
        "import signal, sys\n"
        "signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from circumspect.cli.entry import entry\n"
        "sys.argv[1:] = ['--version']\n"
        "entry()\n"
        "signal.raise_signal(signal.SIGINT)\n"
    )
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (found.returncode, found.stderr) == (0, "")


def pids_masks(_: int) -> str:
    return next(
        line for line in Path("/proc/self/status").read_text().splitlines()
        if line.startswith("SigBlk")
    )  # fmt: skip


def test_workers_are_started_with_ctrl_c_blocked() -> None:
    from circumspect.datasets.worker_pool import worker_pool

    with worker_pool(1) as pool:
        (mask,) = pool.map(pids_masks, [0])
    assert int(mask.split()[1], 16) & 1 << (signal.SIGINT - 1)
