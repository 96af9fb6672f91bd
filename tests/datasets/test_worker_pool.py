"""Worker processes end with their parent."""

import os
import signal
import subprocess
import sys
import textwrap
import time

import pytest

from circumspect.datasets.worker_pool import worker_pool

PROGRAM = """
import os, time
from circumspect.datasets.worker_pool import worker_pool

def work(number):
    print(os.getpid(), flush=True)
    time.sleep(60)

if __name__ == "__main__":
    with worker_pool(2) as pool:
        list(pool.map(work, range(20)))
"""


def is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_workers_get_their_initial_arguments_and_do_the_work():
    with worker_pool(1, os.chdir, "/") as pool:
        assert pool.submit(os.getcwd).result() == "/"


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_an_interrupted_program_leaves_no_worker(sent, tmp_path):
    script = tmp_path / "program.py"
    script.write_text(textwrap.dedent(PROGRAM))
    with subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as program:
        workers = {int(program.stdout.readline()) for _ in range(2)}
        # To the parent alone, as `kill` does; a terminal sends it to all of them.
        program.send_signal(sent)
        program.wait(timeout=30)
        end = time.monotonic() + 20
        while any(map(is_running, workers)) and time.monotonic() < end:
            time.sleep(0.1)
        assert not any(map(is_running, workers))
