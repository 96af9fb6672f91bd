"""Training streams sets in shards: exactly resumable, in one process or several."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from quick_run import QUICK, Silent
from safetensors.torch import load_file
from sharded_kinds import SETTINGS, sharded_kinds

from circumspect.classification import GridSpec
from circumspect.cli.main import main
from circumspect.errors import InputError
from circumspect.training.sharded_training import ShardedTraining, class_weights
from circumspect.training.train import train

pytest.importorskip("pyarrow", reason="pyarrow is not installed")
LOOP = sys.modules[train.__module__]
TWO = replace(QUICK, epochs=2)


@pytest.fixture(scope="module")
def shards(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return sharded_kinds(tmp_path_factory.mktemp("set"), 56)


def run(shards, folder, settings=QUICK, observer=None, **options):
    data = ShardedTraining.read(shards)
    try:
        return train(
            data, settings, folder, observer or Silent(), input_spec=data.input_spec, **options
        )
    finally:
        data.close()


def state_of(folder):
    return load_file(folder / "state.safetensors")


def assert_same_state(one, other):
    states = state_of(one), state_of(other)
    assert states[0].keys() == states[1].keys()
    for name, value in states[0].items():
        torch.testing.assert_close(states[1][name], value, rtol=0, atol=0)


class StopsAt(Silent):
    """Ends a run after a step of its second epoch."""

    def __init__(self, step: int) -> None:
        self.step, self.taken = step, 0

    def stepped(self, epoch, step, steps, loss):
        self.taken += 1
        if (epoch, step) == (1, self.step):
            raise KeyboardInterrupt


def test_a_network_learns_from_shards(shards, tmp_path):
    checkpoint = run(shards, tmp_path / "run", replace(QUICK, epochs=6))
    assert checkpoint.classes == ("plate", "post")
    assert checkpoint.input_spec == SETTINGS.input_spec
    assert checkpoint.training["reached"]["validation_accuracy"] == 1.0


def test_a_run_resumes_at_the_step_of_its_last_state(shards, tmp_path, monkeypatch):
    monkeypatch.setattr(LOOP, "STATE_INTERVAL_S", 0.0)
    run(shards, tmp_path / "whole", TWO)
    with pytest.raises(KeyboardInterrupt):
        run(shards, tmp_path / "parts", TWO, observer=StopsAt(5))
    rest = StopsAt(1000)
    run(shards, tmp_path / "parts", TWO, observer=rest)
    steps = ShardedTraining.read(shards).train.steps(QUICK.batch_size)
    # The step that was interrupted, after the last state, is taken again.
    assert rest.taken == steps - 4
    assert_same_state(tmp_path / "whole", tmp_path / "parts")


def test_the_middle_of_an_epoch_is_resumed_by_as_many_processes(shards, tmp_path, monkeypatch):
    monkeypatch.setattr(LOOP, "STATE_INTERVAL_S", 0.0)
    with pytest.raises(KeyboardInterrupt):
        run(shards, tmp_path / "run", observer=StopsAt(5))
    state = tmp_path / "run" / "state.safetensors"
    content = state.read_bytes()
    assert content.count(b'"processes\\": 1') == 1
    state.write_bytes(content.replace(b'"processes\\": 1', b'"processes\\": 2'))
    with pytest.raises(InputError, match=r"that 2 processes share; resume with as many, not with"):
        run(shards, tmp_path / "run")


def torchrun(shards, folder, *flags, processes=2, **options):
    words = [
        "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", str(processes), "-m",
        "circumspect", "train", "--data", str(shards), "--out", str(folder), "--batch-size", "8",
        "--seed", "1", "--epochs", "2", *flags,
    ]  # fmt: skip
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONWARNINGS": ""}
    return subprocess.Popen(
        [sys.executable, *words], env=environment, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True, **options,
    )  # fmt: skip


def losses(folder):
    with (folder / "epochs.csv").open() as stream:
        return np.array([float(row["loss"]) for row in csv.DictReader(stream)])


def test_two_processes_have_the_loss_of_one_and_resume_after_a_kill(shards, tmp_path):
    job = torchrun(shards, tmp_path / "two")
    output, _ = job.communicate(timeout=300)
    assert job.returncode == 0, output
    run(shards, tmp_path / "one", TWO)
    both = losses(tmp_path / "two"), losses(tmp_path / "one")
    np.testing.assert_allclose(*both, rtol=0.25)
    assert both[0][-1] < both[0][0]

    job = torchrun(shards, tmp_path / "killed")
    wait_for(tmp_path / "killed" / "state.safetensors", job)
    children = subprocess.run(
        ["pgrep", "-P", str(job.pid)], capture_output=True, text=True, check=True
    )
    os.kill(int(children.stdout.split()[-1]), signal.SIGKILL)
    output, _ = job.communicate(timeout=300)
    assert job.returncode != 0, output
    job = torchrun(shards, tmp_path / "killed")
    output, _ = job.communicate(timeout=300)
    assert job.returncode == 0, output
    assert_same_state(tmp_path / "two", tmp_path / "killed")


def wait_for(path, job):
    while not path.exists():
        assert job.poll() is None, job.communicate()[0]
        time.sleep(0.02)


@given(st.lists(st.integers(1, 1000), min_size=2, max_size=9), st.floats(0, 1))
def test_balanced_classes_weigh_the_same_in_all(counts, balance):
    weights = np.array(class_weights(counts, balance))
    assert (weights * counts).sum() == pytest.approx(sum(counts))
    if balance == 1:
        np.testing.assert_allclose(weights * counts, sum(counts) / len(counts))
    if balance == 0:
        np.testing.assert_allclose(weights, 1)


def test_sets_that_can_not_be_trained_are_named(shards, tmp_path):
    few = sharded_kinds(tmp_path, 4, replace(SETTINGS, replicas=1))
    with pytest.raises(InputError, match=r"in 1 row groups: too few for a batch of 8 in 1"):
        run(few, tmp_path / "run")
    with ShardedTraining.read(shards) as data:
        with pytest.raises(InputError, match="2 processes share each batch"):
            data.data(replace(QUICK, batch_size=9), torch.device("cpu"), 2)
        with pytest.raises(InputError, match=r"too few for a batch of 8000 in 1000 processes"):
            data.data(replace(QUICK, batch_size=8000), torch.device("cpu"), 1000)


def test_splits_of_two_sets_do_not_train(shards, tmp_path):
    other = replace(SETTINGS, input_spec=GridSpec(azimuth_views=2))
    mixed = sharded_kinds(tmp_path, 24, other)
    for shard in (mixed / "validation").iterdir():
        shard.unlink()
    for shard in (shards / "validation").iterdir():
        (mixed / "validation" / shard.name).write_bytes(shard.read_bytes())
    with pytest.raises(InputError, match="its splits differ in input_spec; convert the set again"):
        ShardedTraining.read(mixed)


def test_the_command_trains_from_shards(shards, tmp_path, capsys):
    flags = ["train", "--data", str(shards), "--out", str(tmp_path / "run"), "--batch-size", "8"]
    assert main([*flags, "--epochs", "1"]) == 0
    assert "epoch 1, mean-class accuracy" in capsys.readouterr().out
    assert main([*flags, "--replicas", "3"]) == 2
    assert "--replicas goes with a set of objects" in capsys.readouterr().err
    assert main([*flags, "--net", "pointnet"]) == 2
    assert "pointnet takes points" in capsys.readouterr().err
    cut = next((shards / "train").iterdir())
    content = cut.read_bytes()
    try:
        cut.write_bytes(content[: len(content) // 2])
        assert main(flags) == 2
        assert f"{cut.name}: is no whole shard" in capsys.readouterr().err
    finally:
        cut.write_bytes(content)
