"""Results that something else wrote, or cut, are named; none is shown as a figure."""

from __future__ import annotations

import csv
import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from experiment_watcher import Watched
from little_furniture import furniture
from two_kinds import two_kinds

from circumspect.datasets import GridCache
from circumspect.errors import InputError
from circumspect.evaluation.yaw_sweep import YawSweep
from circumspect.nets.registry import net_spec
from circumspect_experiments import Comparison, reproduce_rivals
from circumspect_experiments.stages import fits, trained
from circumspect_experiments.training_record import training_record

OURS_ALONE = Comparison(nets=(), yaw_count=4)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The stages of the shipped classifier alone, which trains nothing."""
    out = tmp_path_factory.mktemp("rivals")
    reproduce(out)
    return out


@pytest.fixture
def out(done, tmp_path):
    shutil.copytree(done, tmp_path / "out")
    return tmp_path / "out"


def reproduce(out):
    return reproduce_rivals(furniture(2, 0), furniture(1, 500), OURS_ALONE, out, Watched())


def assert_refused(out, file):
    """In one line, and the folder that it says to remove is made again."""
    with pytest.raises(InputError) as refused:
        reproduce(out)
    message = str(refused.value)
    assert message.startswith(f"{file}: ")
    assert message.endswith(f"; remove the folder {file.parent}, and it is made again")
    assert "\n" not in message


@pytest.mark.parametrize(
    "text",
    [
        "[]", "{}", "3", "null", "{", "", "[" * 100_000,
        '{"tumbled": 0.5}', '{"tumbled": 0.5, "stood_up": "many"}',
        '{"tumbled": 0.5, "stood_up": NaN}', '{"tumbled": 0.5, "stood_up": 0.5, "worst": 1.0}',
    ],
)  # fmt: skip
def test_a_result_of_another_form(out, text):
    file = out / "circumspect" / "any_way_up" / "result.json"
    file.write_text(text)
    assert_refused(out, file)


def test_times_of_other_networks(out):
    file = out / "times" / "circumspect" / "result.json"
    file.write_text('{"voxnet": 2.0}')
    assert_refused(out, file)


def test_removed_results_are_made_again(out):
    before = json.loads((out / "rivals.json").read_text())
    shutil.rmtree(out / "circumspect" / "any_way_up")
    assert reproduce(out) == before


def test_the_sweep_of_another_stage(out):
    file = out / "circumspect" / "around" / "sweep.npz"
    shutil.copy(out / "circumspect" / "whole" / "sweep.npz", file)
    assert_refused(out, file)


@pytest.mark.parametrize(
    "change",
    [
        lambda sweep: {"labels": sweep.labels[::-1]},
        lambda sweep: {"labels": sweep.labels[1:], "probabilities": sweep.probabilities[:, 1:]},
        lambda sweep: {"probabilities": sweep.probabilities[..., 0]},
        lambda sweep: {"probabilities": np.full_like(sweep.probabilities, np.nan)},
        lambda sweep: {"classes": sweep.classes[::-1]},
    ],
)
def test_a_sweep_over_something_else(out, change):
    file = out / "circumspect" / "around" / "sweep.npz"
    sweep = YawSweep.load(file)
    replace(sweep, **change(sweep)).save(file)
    assert_refused(out, file)


def test_an_invalid_sweep(out):
    file = out / "circumspect" / "around" / "sweep.npz"
    whole = bytearray(file.read_bytes())
    middle = len(whole) // 2
    for broken in (b"", b"no zip", whole[:middle], whole[:middle] + b"\xff" * 40 + whole[middle:]):
        file.write_bytes(broken)
        assert_refused(out, file)
    np.save(file.with_suffix(".npy"), np.zeros(3))
    file.with_suffix(".npy").rename(file)
    assert_refused(out, file)


@pytest.mark.parametrize(
    ("found", "form", "right"),
    [
        ({"a": [True]}, {"a": [bool]}, True),
        ({"a": [1]}, {"a": [bool]}, False),
        ({"a": True}, {"a": float}, False),
        ([0.5, 0.5], [float], False),
        ([float("inf")], [float], False),
        ({}, {}, True),
        ([], {}, False),
    ],
)
def test_a_form_is_keys_lengths_and_types(found, form, right):
    assert fits(found, form) == right


@pytest.fixture(scope="module")
def training(tmp_path_factory):
    at = tmp_path_factory.mktemp("training")
    settings = Comparison(epochs=2).settings("pointnet")
    input_spec, cache = net_spec("pointnet").input_spec, GridCache(at / "grids")
    trained(two_kinds(20), settings, input_spec, at / "run", Watched(), cache)
    return at / "run"


def rows(*epochs, seconds="1.5"):
    return "".join(f"{row}\n" for row in ["epoch,seconds", *(f"{n},{seconds}" for n in epochs)])


@pytest.mark.parametrize(
    "text",
    [
        None, "garbage", "", "\0", rows(), rows(1), rows(2, 1), rows(1, 2, 3), rows(1, "two"),
        rows(1, 2, seconds="nan"), rows(1, 2, seconds="long"), rows(1, 2, seconds="-1"),
        "epoch,seconds\n1\n2\n", "epoch\n1\n2\n",
    ],
)  # fmt: skip
def test_the_record_of_another_training(training, tmp_path, text):
    shutil.copytree(training, tmp_path / "run")
    file = tmp_path / "run" / "epochs.csv"
    if text is None:
        file.unlink()
    else:
        file.write_text(text)
    why = re.escape(f"; remove the folder {file.parent}, and it is trained again")
    with pytest.raises(InputError, match=rf"^{re.escape(str(file))}: .*{why}$"):
        training_record(tmp_path / "run" / "best.safetensors")


def test_the_record_of_a_training(training):
    record = training_record(training / "best.safetensors")
    with (training / "epochs.csv").open(newline="") as stream:
        seconds = [float(row["seconds"]) for row in csv.DictReader(stream)]
    assert record["epochs"] == len(seconds) == 2
    assert record["minutes"] == pytest.approx(sum(seconds) / 60)


def test_a_finished_training_without_its_network(training, tmp_path):
    shutil.copytree(training, tmp_path / "run")
    (tmp_path / "run" / "best.safetensors").unlink()
    settings, input_spec = (
        Comparison(epochs=2).settings("pointnet"),
        net_spec("pointnet").input_spec,
    )
    with pytest.raises(InputError, match=r"best\.safetensors: is missing; remove the folder"):
        trained(two_kinds(20), settings, input_spec, tmp_path / "run", Watched())
