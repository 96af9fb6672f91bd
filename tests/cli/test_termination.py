"""SIGTERM, as service managers send it: a run is saved as after Ctrl-C."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from circumspect.cli.main import Terminated, ends_as_ctrl_c_does, main

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there SIGTERM ends at once")


def test_a_terminated_scan_saves_its_result(tmp_path: Path) -> None:
    out = tmp_path / "run"
    program = "import sys; from circumspect.cli.main import main; sys.exit(main(sys.argv[1:]))"
    process = subprocess.Popen(
        [sys.executable, "-c", program, "scan", "chair", "--out", str(out)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        end = time.monotonic() + 120
        log = out / "log.jsonl"
        while not log.is_file() or log.read_text().count("\n") < 3:
            assert process.poll() is None, "it ended by itself"
            assert time.monotonic() < end, "no frame came"
            time.sleep(0.1)
        process.terminate()
        _, stderr = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 143
    assert "Traceback" not in stderr
    assert stderr.splitlines()[-1].startswith("circumspect: interrupted;")
    result = json.loads((out / "result.json").read_text())
    assert result["interrupted"] is True
    assert result["frames"] >= 3
    assert (out / "model.ply").is_file()


def test_the_sigterm_handler_is_installed_only_while_a_command_runs() -> None:
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    with pytest.raises(Terminated), ends_as_ctrl_c_does():
        signal.raise_signal(signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@pytest.mark.parametrize("before", [signal.SIG_IGN, lambda *_: None], ids=["ignored", "another"])
def test_a_foreign_sigterm_handler_is_kept(before: signal.Handlers) -> None:
    signal.signal(signal.SIGTERM, before)
    try:
        with ends_as_ctrl_c_does():
            assert signal.getsignal(signal.SIGTERM) is before
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def test_commands_run_in_other_threads_too(capsys: pytest.CaptureFixture[str]) -> None:
    codes: list[int] = []
    thread = threading.Thread(target=lambda: codes.append(main(["nets"])))
    thread.start()
    thread.join()
    assert codes == [0]
    assert "moon2018" in capsys.readouterr().out
