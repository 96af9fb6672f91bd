"""`--json`: standard output holds JSON and nothing else, however a command ends.

The commands are those of the program, so that a new one can not be forgotten.
"""

from __future__ import annotations

import ast
import json
import signal
import sys
from pathlib import Path
from types import FrameType

import pytest
from tiny_commands import TinyInputs, Words, command_words

from circumspect.cli.main import main

COMMANDS = list(command_words(only_json=True))
TESTS = Path(__file__).resolve().parents[1]
MISSING, BROKEN = "no-such-file.ply", "BROKEN"
FAULTY = {
    "demo": ["--object", "chiar"],
    "scan": [MISSING],
    "classify": [BROKEN, MISSING],
    "explain": [BROKEN],
    "models": ["chiar"],
    "teach": ["lamp", BROKEN],
    "replay": [BROKEN],
    "watch": ["--camera", BROKEN],
    "gather": ["--out", "set", "--from", BROKEN, "--label", "chair"],
    "record info": [BROKEN],
    "ros2": ["--params-file", MISSING],
    "locate simulate": ["--cameras", "0"],
    "locate board": ["--out", "file"],
    "locate intrinsics": [BROKEN, "--out", "room.json"],
    "locate extrinsics": [BROKEN, "--survey", MISSING, "--intrinsics", MISSING, "--out", "o.json"],
    "locate track": [BROKEN, "--calibration", MISSING],
    "evaluate": ["--data", BROKEN],
    "reproduce table2": ["--data", BROKEN],
    "reproduce rivals": ["--data", BROKEN],
    "reproduce robustness": ["--data", BROKEN],
    "reproduce unknown": ["--data", BROKEN],
    "reproduce real": ["--crops", BROKEN],
    "data fetch": ["modelnet10", "--sha256", "no checksum"],
    "data verify": [MISSING],
    "data import": ["sweethome3d", BROKEN],
    "data convert": [MISSING],
    "nets": ["--classes", "0"],
}
"""What each command is given so that it fails with a known fault; doctor takes nothing."""
QUICK = (
    ("classify",), ("models",), ("record", "info"), ("locate", "board"), ("data", "fetch"),
    ("data", "verify"), ("data", "import"), ("doctor",),
)  # fmt: skip
ELSEWHERE = {
    "demo": "cli/test_scan_command.py",  # the same run, under another name
    "scan": "cli/test_recording_commands.py",
    "explain": "cli/test_explain_command.py",
    "teach": "cli/test_teach_command.py",
    "replay": "cli/test_recording_commands.py",
    "watch": "cli/test_watch_command.py",
    "gather": "cli/test_gather_command.py",
    "ros2": "ros/test_ros2_command.py",
    "locate simulate": "cli/test_locate_command.py",
    "locate intrinsics": "cli/test_locate_command.py",
    "locate extrinsics": "cli/test_locate_command.py",
    "locate track": "cli/test_locate_command.py",
    "evaluate": "cli/test_training_commands.py",
    "reproduce table2": "cli/test_before_training.py",
    "reproduce rivals": "cli/test_before_training.py",
    "reproduce robustness": "cli/test_before_training.py",
    "reproduce unknown": "cli/test_before_training.py",
    "reproduce real": "experiments/test_real.py",
    "data convert": "gathering/test_conversion.py",
    "nets": "cli/test_commands.py",
}
"""Tests of commands that take longer: they read the whole standard output as JSON."""


def name_of(command: Words) -> str:
    return " ".join(command)


def require_json_alone(printed: str) -> None:
    for line in printed.splitlines():
        assert isinstance(json.loads(line), dict), line


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> TinyInputs:
    return TinyInputs(tmp_path_factory.mktemp("inputs"))


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a folder with a file that no command can use, by every command's suffix."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / BROKEN).write_bytes(b"\x00broken\xff" * 20)
    (tmp_path / "file").write_text("in the way of a folder")


@pytest.mark.parametrize("command", COMMANDS, ids=name_of)
def test_a_wrong_flag_prints_nothing_on_standard_output(
    command: Words, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*command, "--json", "--no-such-flag"])
    printed = capfd.readouterr()
    assert (ended.value.code, printed.out) == (2, "")
    assert printed.err


@pytest.mark.parametrize("command", COMMANDS, ids=name_of)
def test_a_known_error_prints_nothing_on_standard_output(
    command: Words, capfd: pytest.CaptureFixture[str]
) -> None:
    if command == ("doctor",):
        pytest.skip("nothing is given to it")
    assert main([*command, *FAULTY[name_of(command)], "--json"]) == 2
    printed = capfd.readouterr()
    assert printed.out == ""
    assert all(line.startswith("circumspect: ") for line in printed.err.splitlines()), printed.err


# An interrupt may come while the standard library opens a zip file: `__del__` then misses attributes.
# In the process of a command `cli.entry` silences that.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("command", QUICK, ids=name_of)
def test_results_are_json_alone_even_after_ctrl_c(
    command: Words, inputs: TinyInputs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert command in COMMANDS
    words = [*inputs.words(command, tmp_path / "whole"), "--json"]
    capfd.readouterr()
    calls = counted(words)
    printed = capfd.readouterr().out
    assert printed
    require_json_alone(printed)
    for share in (0.1, 0.5, 0.9):
        again = [*inputs.words(command, tmp_path / f"after {share}"), "--json"]
        code = interrupted(again, int(share * calls))
        left = capfd.readouterr()
        require_json_alone(left.out)
        assert code in (130, 0, 1), left.err
        assert "Traceback" not in left.err


def counted(words: list[str]) -> int:
    """Run a command that ends well, and count the calls of functions."""
    calls = 0

    def count(frame: FrameType, event: str, argument: object) -> None:
        nonlocal calls
        calls += 1

    assert main(words) in (0, 1)  # Whatever is imported is imported now.
    sys.setprofile(count)
    try:
        main(words)
    finally:
        sys.setprofile(None)
    return calls


def interrupted(words: list[str], moment: int) -> int:
    """Run a command with Ctrl-C at a certain call of a function."""
    calls = 0

    def press(frame: FrameType, event: str, argument: object) -> None:
        nonlocal calls
        calls += 1
        if calls == moment:
            sys.setprofile(None)
            signal.raise_signal(signal.SIGINT)

    sys.setprofile(press)
    try:
        return main(words)
    finally:
        sys.setprofile(None)


def test_every_command_is_tested() -> None:
    names = {name_of(command) for command in COMMANDS}
    assert names == set(FAULTY) | {"doctor"}
    assert names == set(ELSEWHERE) | {name_of(command) for command in QUICK}


@pytest.mark.parametrize("file", sorted(set(ELSEWHERE.values())))
def test_the_other_tests_ask_for_json(file: str) -> None:
    tree = ast.parse((TESTS / file).read_text())
    texts = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    assert "--json" in texts
