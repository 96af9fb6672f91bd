"""The Tab key, pressed in real shells."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from circumspect.cli.main import COMMANDS, main

BASH = """
source {script}
for words in {tries}; do
  COMP_WORDS=(${{words//_/ }}); [[ $words == *_ ]] && COMP_WORDS+=("")
  COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 )); COMPREPLY=()
  _circumspect
  echo "$words: ${{COMPREPLY[*]}}"
done
"""


def needs(program):
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed")


@pytest.fixture
def script(tmp_path, capsys):
    def written(shell):
        assert main(["completion", shell]) == 0
        path = tmp_path / f"completion.{shell}"
        path.write_text(capsys.readouterr().out)
        return path

    return written


def test_bash_completes_commands_flags_values_and_words(script, tmp_path):
    needs("bash")
    tries = {
        "circumspect_": None,
        "circumspect_sc": "scan",
        "circumspect_scan_cha": "chair",
        "circumspect_scan_--plan": "--planner",
        "circumspect_scan_chair_--planner_": "normals circle confidence",
        "circumspect_data_": "fetch verify import convert",
        "circumspect_locate_tr": "track",
        "circumspect_locate_track_--cal": "--calibration",
        "circumspect_classify_": "",
        "circumspect_classify_x.ply_--js": "--json",
        "circumspect_classify_x.ply_--model_": "robot modelnet10",
        "circumspect_classify_--model_mo": "modelnet10",
        "circumspect_classify_--model_own": "",
        "circumspect_evaluate_--model_ro": "robot",
        "circumspect_models_": "robot modelnet10",
    }
    code = BASH.format(script=script("bash"), tries=" ".join(tries))
    done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stderr == ""
    replies = dict(line.split(":", 1) for line in done.stdout.splitlines())
    assert set(replies.pop("circumspect_").split()) == set(COMMANDS)
    wanted = {words: reply for words, reply in tries.items() if reply is not None}
    assert {words: reply.strip() for words, reply in replies.items()} == wanted


def typed(shell, setup, line, folder):
    """What an interactive shell shows after a line and the Tab key."""
    pty, fcntl = pytest.importorskip("pty"), pytest.importorskip("fcntl")
    master, slave = pty.openpty()
    environment = {**os.environ, "TERM": "dumb", "PS1": "ready> ", "INPUTRC": "/dev/null"}
    process = subprocess.Popen(
        shell, stdin=slave, stdout=slave, stderr=slave, cwd=folder, env=environment,
        start_new_session=True,
    )  # fmt: skip
    os.close(slave)
    fcntl.fcntl(master, fcntl.F_SETFL, os.O_NONBLOCK)

    def read_until(word, seconds=20.0):
        text, end = "", time.monotonic() + seconds
        while word not in text and time.monotonic() < end:
            try:
                text += os.read(master, 65536).decode(errors="replace")
            except BlockingIOError:
                time.sleep(0.02)
            except OSError:
                break
        return text

    try:
        os.write(master, f"{setup}; echo set''up\n".encode())
        read_until("setup\r\n")
        os.write(master, f"{line}\t".encode())
        return read_until(f"{line[line.rindex(' ') + 1 :]}ir.ply" if "cha" in line else "--planner")
    finally:
        process.kill()
        process.wait()
        os.close(master)


@pytest.mark.parametrize(
    ("line", "completed"),
    [("circumspect classify cha", "chair.ply"), ("circumspect scan --plan", "--planner")],
)
def test_bash_by_hand(script, tmp_path, line, completed):
    needs("bash")
    (tmp_path / "chair.ply").touch()
    shell = ["bash", "--norc", "--noprofile", "-i"]
    assert completed in typed(shell, f"source {script('bash')}", line, tmp_path)


@pytest.mark.parametrize(
    ("line", "completed"),
    [("circumspect classify cha", "chair.ply"), ("circumspect scan --plan", "--planner")],
)
def test_zsh_by_hand(script, tmp_path, line, completed):
    needs("zsh")
    (tmp_path / "chair.ply").touch()
    script("zsh").rename(tmp_path / "_circumspect")
    setup = f"fpath+={tmp_path}; autoload -Uz compinit; compinit -D -u"
    assert completed in typed(["zsh", "-f", "-i"], setup, line, tmp_path)


@pytest.mark.parametrize(
    ("line", "completed"),
    [
        ("circumspect sc", {"scan"}),
        ("circumspect data f", {"fetch"}),
        ("circumspect classify cha", {"chair.ply"}),
        ("circumspect scan chair --planner c", {"circle", "confidence"}),
        ("circumspect classify chair.ply --model m", {"modelnet10"}),
    ],
)
def test_fish(script, tmp_path, line, completed):
    needs("fish")
    (tmp_path / "chair.ply").touch()
    # fish looks at commands only that it can find.
    code = f"set PATH {Path(sys.executable).parent} $PATH; source {script('fish')}; complete -C '{line}'"
    done = subprocess.run(
        ["fish", "--no-config", "-c", code],
        capture_output=True, text=True, cwd=tmp_path, timeout=60,
    )  # fmt: skip
    assert {entry.split("\t")[0] for entry in done.stdout.splitlines()} == completed


def test_an_unknown_shell_is_refused(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["completion", "tcsh"])
    assert stop.value.code == 2
    assert "bash" in capsys.readouterr().err
