"""Sets in shards are evaluated shard by shard: the figures are those of the whole set."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sharded_kinds import SETTINGS, sharded_kinds

from circumspect.cli.commands import evaluate_shards
from circumspect.cli.main import main
from circumspect.datasets.sharded_set import ShardedSet
from circumspect.evaluation.calibration import BINS, bins_of
from circumspect.evaluation.shard_answers import ShardAnswers

pytest.importorskip("pyarrow", reason="pyarrow is not installed")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with shards/, their packs, and a briefly trained network."""
    folder = tmp_path_factory.mktemp("evaluated")
    shards = sharded_kinds(folder, 56, replace(SETTINGS, shard_size=6))
    words = ["--data", str(shards), "--out", str(folder / "run"), "--batch-size", "6"]
    assert main(["train", *words, "--epochs", "1"]) == 0
    return folder


def evaluate(folder, out, *flags, data="shards"):
    words = ["--model", str(folder / "run"), "--data", str(folder / data), "--out", str(out)]
    return main(["evaluate", *words, "--split", "test", *flags])


def metrics_of(out):
    return json.loads((out / "metrics.json").read_text())


def test_shards_give_the_figures_of_the_whole_set(folder, tmp_path, capsys):
    assert evaluate(folder, tmp_path / "shards", "--workers", "2", "--json") == 0
    sharded = json.loads(capsys.readouterr().out)
    assert sharded == metrics_of(tmp_path / "shards")
    assert sharded["shards"] == 2
    assert evaluate(folder, tmp_path / "whole", "--yaw", "0", data="packs") == 0
    whole = metrics_of(tmp_path / "whole")
    assert sharded["objects"] == whole["objects"] == 10
    assert sharded["accuracy"] == whole["accuracy"][0]
    assert sharded["mean_class_accuracy"] == whole["mean_class_accuracy"][0]
    assert sharded["confusion"] == whole["confusion"]
    name = "expected_calibration_error"
    assert sharded[name] == pytest.approx(whole[name], abs=1e-6)
    assert not sharded["seen_in_training"]
    assert {path.suffix for path in (tmp_path / "shards").iterdir()} == {
        ".json", ".jsonl", ".png", ".toml",
    }  # fmt: skip


def test_shards_that_train_are_called_seen(folder, tmp_path, capsys):
    out = tmp_path / "train"
    assert evaluate(folder, out, "--split", "train", "--workers", "1") == 0
    assert "do not quote these figures" in capsys.readouterr().out


def test_an_interrupted_evaluation_resumes(folder, tmp_path, monkeypatch):
    out, asked = tmp_path / "out", []

    class Pool:
        name = "here"

        def outcomes(self, jobs, work):
            for job in jobs:
                if len(asked) == 1:
                    raise KeyboardInterrupt
                asked.append(job.key)
                yield job, work(job)

    class Cut:
        def __enter__(self):
            return Pool()

        def __exit__(self, *_):
            pass

    module = "circumspect.cli.commands.evaluate.opened_pool"
    with monkeypatch.context() as patch:
        patch.setattr(module, lambda *_: Cut())
        assert evaluate(folder, out) == 130
    lines = (out / evaluate_shards.DONE).read_text().splitlines()
    assert [json.loads(line)["key"] for line in lines] == asked
    # Answers of another network are not taken for this one's.
    assert evaluate(folder, out, "--workers", "1") == 0
    assert len((out / evaluate_shards.DONE).read_text().splitlines()) == 2
    assert metrics_of(out)["objects"] == 10
    other = evaluate(folder, out, "--workers", "1", "--split", "validation")
    assert other == 0
    assert metrics_of(out)["split"] == "validation"


def test_sets_that_can_not_be_evaluated_are_named(folder, tmp_path, capsys):
    for flags, message in (
        (["--yaw", "0,45"], "leave --yaw out"),
        (["--workers", "0"], "at least one process"),
        (["--model", "modelnet10"], "the weights know bathtub, "),
    ):
        assert evaluate(folder, tmp_path / "out", *flags) == 2
        assert message in capsys.readouterr().err
    assert evaluate(folder, tmp_path / "out", "--workers", "1", data="packs") == 2
    assert "--workers goes with shards" in capsys.readouterr().err


def test_a_broken_shard_is_named_and_the_others_are_kept(folder, tmp_path, capsys):
    first, last = sorted((folder / "shards" / "test").iterdir())
    whole = last.read_bytes()
    start = whole.index(b"test_")
    try:
        last.write_bytes(whole[:4] + bytes(40) + whole[44:])
        assert evaluate(folder, tmp_path / "out", "--workers", "1") == 2
        assert f"{last.name}: is broken" in capsys.readouterr().err
    finally:
        last.write_bytes(whole)
    assert start
    lines = (tmp_path / "out" / evaluate_shards.DONE).read_text().splitlines()
    assert [json.loads(line)["key"] for line in lines] == [f"test/{first.name}"]
    assert evaluate(folder, tmp_path / "out", "--workers", "1") == 0


def test_shards_for_another_network_are_refused(folder, tmp_path, capsys):
    other = sharded_kinds(
        tmp_path, 24, replace(SETTINGS, input_spec=replace(SETTINGS.input_spec, margin=1.2))
    )
    assert ShardedSet.read(other, "test").head.input_spec["margin"] == 1.2
    words = ["--model", str(folder / "run"), "--data", str(other), "--out", str(tmp_path / "o")]
    assert main(["evaluate", *words]) == 2
    assert "are of another input specification than the network's" in capsys.readouterr().err


@given(st.lists(st.tuples(st.floats(0.5, 1), st.booleans()), min_size=1, max_size=30), st.data())
def test_bins_of_shards_add_up(answers, data):
    confidence, correct = (np.array(column) for column in zip(*answers, strict=True))
    cut = data.draw(st.integers(0, len(answers)))
    parts = bins_of(confidence[:cut], correct[:cut]) + bins_of(confidence[cut:], correct[cut:])
    np.testing.assert_allclose(parts, bins_of(confidence, correct))
    assert parts.shape == (3, BINS)


def test_answers_add_up_over_starts():
    one = {"confusion": {"0": [[2, 1], [0, 1]]}, "bins": np.ones((3, BINS)).tolist(), "fitted": 1}
    two = {"confusion": {"45": [[0, 1], [0, 3]], "0": [[1, 0], [0, 0]]}, "fitted": 0,
           "bins": np.ones((3, BINS)).tolist()}  # fmt: skip
    found = ShardAnswers.added([one, two])
    assert found.fitted == 1
    np.testing.assert_array_equal(found.total, [[3, 2], [0, 4]])
    metrics = found.metrics()
    assert metrics["accuracy"] == pytest.approx(7 / 9)
    assert metrics["mean_class_accuracy"] == pytest.approx((0.6 + 1) / 2)
    assert metrics["starts_deg"] == [0.0, 45.0]
    assert metrics["accuracy_from_start"] == [pytest.approx(0.8), pytest.approx(0.75)]
