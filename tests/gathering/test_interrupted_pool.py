"""Ctrl-C ends a pool of long jobs at once: what runs is dropped, what waits is not begun."""

import os
import signal
import subprocess
import sys
import time

import pytest

PROGRAM = """
import sys, time
from dataclasses import dataclass
from pathlib import Path
from circumspect.gathering import LocalPool, run_all

@dataclass(frozen=True)
class Nap:
    key: str

def sleep(nap):
    Path(nap.key).touch()
    time.sleep(60)
    return {"key": nap.key}

if __name__ == "__main__":
    try:
        naps = [Nap(f"nap-{n}") for n in range(6)]
        run_all(naps, sleep, Path("naps.jsonl"), LocalPool(2), lambda *progress: None)
    except KeyboardInterrupt:
        sys.exit(130)
"""


@pytest.mark.parametrize("everybody", [True, False], ids=["terminal", "parent alone"])
def test_ctrl_c_does_not_wait_for_the_jobs(tmp_path, everybody):
    (tmp_path / "naps.py").write_text(PROGRAM)
    process = subprocess.Popen(
        [sys.executable, "naps.py"], cwd=tmp_path, start_new_session=True, stderr=subprocess.DEVNULL
    )
    try:
        end = time.monotonic() + 60
        while len(list(tmp_path.glob("nap-*"))) < 2:
            assert process.poll() is None, "it ended by itself"
            assert time.monotonic() < end, "no job began"
            time.sleep(0.05)
        interrupt = os.killpg if everybody else os.kill
        interrupt(process.pid, signal.SIGINT)
        assert process.wait(timeout=20) == 130
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    assert len(list(tmp_path.glob("nap-*"))) == 2, "a waiting job was begun"
