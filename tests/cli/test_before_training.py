"""Faults that are reported before hours of training, not after them."""

import json

import numpy as np
import pytest
from two_kinds import two_kinds

from circumspect.cli.main import main


def run(*words):
    return main([str(word) for word in words])


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--net", "3dshapenets", "--cells", 25, 25, 25), "3dshapenets needs 26 cells"),
        (("--net", "planes", "--cells", 20, 32, 20), "multiples of 8"),
        (("--net", "moon2018", "--damage", 0.5), "leave out --damage"),
        (("--net", "moon2018", "--random-yaw"), "give --replicas 2 or more, not 1"),
        (("--net", "headed-planes", "--random-yaw"), "learns which way objects face"),
        (("--net", "moon2018", "--pool", "max", "--stretch", 0.1, "--partial", 0.5),
         "moon2018-max is shown objects as they are; leave out --stretch, --partial"),
    ],
)  # fmt: skip
def test_impossible_flags_are_refused_before_the_data_are_opened(tmp_path, capsys, words, why):
    missing, out = tmp_path / "none", tmp_path / "run"
    assert run("train", "--data", missing, "--out", out, *words) == 2
    stderr = capsys.readouterr().err
    assert why in stderr
    assert stderr.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    ("flags", "why"),
    [
        (("--yaw-count", -3), "--yaw-count must be 1 to 3600, not -3"),
        (("--yaw-count", 0), "--yaw-count must be 1 to 3600, not 0"),
        (("--yaw-count", 100_000_000_000), "--yaw-count must be 1 to 3600, not 100000000000"),
        (("--robot", "no-such-folder"), "no-such-folder/manifest.jsonl: can not be read"),
    ],
)
def test_impossible_experiments_are_refused_before_the_data_are_opened(
    tmp_path, capsys, flags, why
):
    missing, out = tmp_path / "none", tmp_path / "out"
    assert run("reproduce", "table2", "--data", missing, "--out", out, *flags) == 2
    stderr = capsys.readouterr().err
    assert why in stderr
    assert stderr.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize("as_json", [False, True])
def test_the_first_table_is_printed_before_the_robot_half_begins(
    tmp_path, capsys, monkeypatch, as_json
):
    """The first half takes hours, and the second takes hours more."""

    def first(train, test, settings, out, *_):
        out.mkdir()
        (out / "table2.md").write_text("the first table")
        return {"rows": [1]}

    def second(scans, settings, out, *_):
        assert ("the first table" in capsys.readouterr().out) == (not as_json)
        (out / "table2_robot.md").write_text("the second table")
        return {"rows": [2]}

    every = two_kinds(8)
    sets = {"train": every.subset(np.arange(4)), "test": every.subset(np.arange(4, 8))}
    monkeypatch.setattr("circumspect.datasets.open_data_set", lambda data, split, _: sets[split])
    monkeypatch.setattr("circumspect_experiments.reproduce_table2", first)
    monkeypatch.setattr("circumspect_experiments.reproduce_robot", second)
    monkeypatch.setattr("circumspect_experiments.RobotScans.read", lambda gathered: gathered)
    words = ("reproduce", "table2", "--data", tmp_path, "--out", tmp_path / "out")
    assert run(*words, "--robot", tmp_path, *(["--json"] if as_json else [])) == 0
    printed = capsys.readouterr().out
    if as_json:
        assert json.loads(printed) == {"rows": [1], "robot": {"rows": [2]}}
    else:
        assert printed.strip() == "the second table"
    assert (tmp_path / "out" / "config.toml").is_file()
