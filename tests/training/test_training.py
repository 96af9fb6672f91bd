import csv
import json
import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from quick_run import QUICK, Silent, as_meant, run
from safetensors.torch import load_file
from two_kinds import two_kinds

from circumspect.classification import GridSpec, PointsSpec
from circumspect.datasets import Augmentation, GridCache, ObjectSet
from circumspect.datasets.augmented_clouds import AugmentedClouds, AugmentedGrids, AugmentedPoints
from circumspect.errors import CircumspectError, InputError
from circumspect.grid import hits_batch
from circumspect.nets import build_net
from circumspect.training import TrainingSettings
from circumspect.training.draws import (
    MIN_DRAWS,
    class_chances,
    draw_epoch,
    learning_rate_at,
    passes_for,
)
from circumspect.training.samples import TrainingSamples
from circumspect.training.train import _is_best, train
from circumspect.training.training_data import ObjectExaminer


def test_learns_and_logs(tmp_path):
    settings = TrainingSettings(epochs=6, batch_size=8, replicas=2, seed=1)
    checkpoint = run(tmp_path / "run", settings, two_kinds(96))
    assert checkpoint.classes == ("plate", "post")
    assert checkpoint.training["reached"]["validation_accuracy"] == 1.0
    with (tmp_path / "run" / "epochs.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["epoch"] for row in rows] == ["1", "2", "3", "4", "5", "6"]
    assert float(rows[-1]["loss"]) < float(rows[0]["loss"])
    written = json.loads((tmp_path / "run" / "config.json").read_text())
    assert written["settings"]["seed"] == 1
    assert list((tmp_path / "run" / "tensorboard").iterdir())


def assert_same_state(one, other):
    """The last state, not the best epoch: nets, averages and the optimizer's moments."""
    states = [load_file(folder / "state.safetensors") for folder in (one, other)]
    assert states[0].keys() == states[1].keys()
    assert any(name.startswith("optimizer/") for name in states[0])
    for name, value in states[0].items():
        torch.testing.assert_close(states[1][name], value, rtol=0, atol=0)


def test_smallest_loss_breaks_ties_between_epochs():
    def row(accuracy, loss):
        return {"validation_accuracy": accuracy, "validation_loss": loss}

    before = [row(0.5, 0.69), row(0.5, 0.60)]
    assert _is_best(row(0.5, 0.55), before)
    assert not _is_best(row(0.5, 0.65), before)
    assert _is_best(row(0.6, 0.90), before)
    assert not _is_best(row(0.4, 0.10), before)


@pytest.mark.parametrize(("fewest", "kept"), [(1, 1), (1000, 3)])
def test_a_few_held_back_objects_do_not_choose_the_epoch(tmp_path, monkeypatch, fewest, kept):
    """The first epoch looks best, but a handful of objects is too few to decide."""
    reported = iter([0.9, 0.5, 0.6])
    module = sys.modules[train.__module__]
    monkeypatch.setattr(module, "MIN_VALIDATION_OBJECTS", fewest)
    monkeypatch.setattr(
        ObjectExaminer,
        "examine",
        lambda *_: {"validation_accuracy": next(reported), "validation_loss": 1.0},
    )
    reached = run(tmp_path / "run").training["reached"]
    assert reached["epoch"] == kept
    assert reached["validation_accuracy"] == (0.9 if kept == 1 else 0.6)


def test_resumed_run_equals_an_uninterrupted_one(tmp_path):
    run(tmp_path / "whole")
    run(tmp_path / "parts", stop_after=1)
    run(tmp_path / "parts")
    assert_same_state(tmp_path / "whole", tmp_path / "parts")


@pytest.mark.parametrize(
    ("net", "input_spec"),
    [("moon2018", GridSpec(shape=(14, 14, 14))), ("pointnet", PointsSpec(128))],
)
def test_other_optimizers_and_inputs_resume_as_well(tmp_path, net, input_spec):
    settings = as_meant(net, epochs=2)
    run(tmp_path / "whole", settings, input_spec=input_spec)
    run(tmp_path / "parts", settings, input_spec=input_spec, stop_after=1)
    run(tmp_path / "parts", settings, input_spec=input_spec)
    assert_same_state(tmp_path / "whole", tmp_path / "parts")


@pytest.mark.parametrize(
    ("net", "input_spec"),
    [
        ("moon2018", GridSpec(shape=(14, 14, 14))),
        ("moon2018-max", GridSpec("rectangular", (14, 14, 14))),
        ("voxnet", GridSpec("rectangular", (16, 16, 16))),
        ("pointnet", PointsSpec(128)),
        ("voxelnet", PointsSpec(512, surface=True)),
        ("pointmlp", PointsSpec(192, farthest_first=True)),
    ],
)
def test_every_kind_of_network_learns(tmp_path, net, input_spec):
    settings = as_meant(net, epochs=8)
    checkpoint = run(tmp_path / "run", settings, two_kinds(64), input_spec=input_spec)
    assert checkpoint.input_spec == input_spec
    assert checkpoint.training["reached"]["validation_accuracy"] == 1.0


def test_objects_that_are_not_augmented_are_all_the_same(tmp_path):
    objects, input_spec = two_kinds(4), GridSpec()
    clouds = AugmentedClouds(objects, Augmentation.none(), 0)
    one, other = (clouds.samples(2, replica)[:300] for replica in range(2))
    np.testing.assert_array_equal(one, other)
    made = AugmentedGrids(clouds, input_spec, 1, GridCache(tmp_path))
    grid = made.batch(np.array([2]), np.array([0]))[0, 0]
    vertices = hits_batch([input_spec.unit_bounds], [one])[0]
    assert (grid >= vertices).all()


def test_training_grids_have_no_margin(tmp_path):
    clouds = AugmentedClouds(two_kinds(4), Augmentation(), 0)
    made = []
    for input_spec in (GridSpec(), GridSpec(margin=1.3)):
        AugmentedGrids(clouds, input_spec, 1, GridCache(tmp_path))
        made.append(sorted(path for path in tmp_path.rglob("*") if path.is_file()))
    assert made[0]
    assert made[1] == made[0]


@pytest.mark.parametrize("input_spec", [GridSpec(margin=1.3), PointsSpec(128, margin=1.3)])
def test_objects_without_augmentation_have_the_margin_of_the_input_spec(tmp_path, input_spec):
    objects, cache = two_kinds(4), GridCache(tmp_path)
    settings = replace(QUICK, augmented=False, replicas=1)

    def shown(asked):
        samples = TrainingSamples(objects, settings, asked, cache, Silent().preparing)
        (inputs,) = samples.inputs(np.arange(4), np.zeros(4, int))
        return inputs

    wide, tight = shown(input_spec), shown(replace(input_spec, margin=1.0))
    if isinstance(input_spec, GridSpec):
        # Cells are as large as the input specification's: at most one more or less of them is reached.
        for index in range(4):
            asked = input_spec.inputs(objects.cloud(index))[0, 0, 0]
            assert np.abs(reach(wide[index, 0]) - reach(asked)).max() <= 1
        assert len(list(tmp_path.iterdir())) == 2
    else:
        np.testing.assert_allclose(wide * np.float32(1.3), tight, rtol=1e-5, atol=1e-6)


def reach(grid):
    """Of the occupied cells: the outermost radius, the lowest and the highest."""
    heights = np.flatnonzero(grid.any(axis=(0, 1)))
    return np.array([np.flatnonzero(grid.any(axis=(1, 2))).max(), heights[0], heights[-1]])


def test_a_margin_that_is_not_trained_on_is_refused(tmp_path):
    settings = replace(QUICK, augmentation=Augmentation(scale=(0.95, 1.05)))
    with pytest.raises(InputError, match=r"margin 1\.1 .* augmentation.scale is 0\.95 … 1\.05"):
        run(tmp_path / "run", settings)
    assert not (tmp_path / "run").exists()


def test_points_of_a_batch_are_those_of_each_object():
    clouds = AugmentedClouds(two_kinds(6), Augmentation(), 3)
    made = AugmentedPoints(clouds, PointsSpec(200, surface=True))
    chosen, replicas = np.array([4, 1, 4]), np.array([0, 1, 2])
    batch = made.batch(chosen, replicas)
    assert batch.shape == (3, 200, 3)
    for row, i, replica in zip(batch, chosen, replicas, strict=True):
        there = {tuple(point) for point in clouds.samples(int(i), int(replica)).tolist()}
        assert {tuple(point) for point in row.tolist()} <= there


def test_the_seed_alone_decides_how_the_weights_begin(tmp_path, monkeypatch):
    began = []

    def noted(*words):
        net = build_net(*words)
        began.append({key: value.clone() for key, value in net.state_dict().items()})
        return net

    monkeypatch.setattr(sys.modules[train.__module__], "build_net", noted)
    torch.rand(7)
    run(tmp_path / "run", stop_after=1)
    torch.manual_seed(QUICK.seed)
    for key, value in build_net(QUICK.net, 2, GridSpec()).state_dict().items():
        assert torch.equal(began[0][key], value), key


def test_a_run_killed_within_an_epoch_restarts_that_epoch(tmp_path):
    class Killer(Silent):
        def stepped(self, epoch, step, steps, loss):
            if epoch == 1 and step == 2:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(two_kinds(), QUICK, tmp_path / "run", Killer(), GridCache(tmp_path / "grids"))
    run(tmp_path / "run")
    run(tmp_path / "whole")
    assert_same_state(tmp_path / "run", tmp_path / "whole")


def test_without_validation_all_objects_train_and_the_last_epoch_is_kept(tmp_path):
    settings = TrainingSettings(epochs=2, batch_size=8, replicas=1, validation=False)
    checkpoint = run(tmp_path / "run", settings)
    assert checkpoint.training["reached"]["epoch"] == 2
    assert "validation_accuracy" not in checkpoint.training["reached"]


def test_bf16_trains(tmp_path):
    settings = replace(QUICK, epochs=1, validation=False)
    plain = run(tmp_path / "plain", settings)
    checkpoint = run(tmp_path / "run", replace(settings, precision="bf16"))
    losses = [c.training["reached"]["loss"] for c in (checkpoint, plain)]
    assert losses[0] != losses[1]
    assert losses[0] == pytest.approx(losses[1], rel=0.1)


def test_a_class_without_objects_is_named(tmp_path):
    objects = two_kinds()
    three = ObjectSet(objects.points_xyz, objects.labels, objects.names, ("plate", "post", "urn"))
    with pytest.raises(InputError, match="urn"):
        run(tmp_path / "run", objects=three)


def test_impossible_settings_are_refused_before_anything_is_written(tmp_path):
    for settings, complaint in (
        (TrainingSettings(batch_size=1), "--batch-size 1: batch norm .* give 2 or more"),
        (TrainingSettings(net="plane"), "did you mean planes"),
    ):
        with pytest.raises(InputError, match=complaint):
            run(tmp_path / "run", settings)
        assert not (tmp_path / "run" / "state.safetensors").exists()
    with pytest.raises(InputError, match="multiples of 8"):
        run(tmp_path / "run", input_spec=GridSpec(shape=(20, 32, 20)))
    assert not (tmp_path / "grids").exists(), "grids that no network takes were made"
    # The corrected command is not refused.
    run(tmp_path / "run", stop_after=1)


@pytest.mark.parametrize(
    ("validation", "count", "remedy"),
    [(True, 2, "add objects, or hold none back with --no-validation$"), (False, 1, "add objects$")],
)
def test_too_few_objects_are_refused_with_a_remedy_that_works(tmp_path, validation, count, remedy):
    every = two_kinds()
    few = ObjectSet(
        every.points_xyz[:count], every.labels[:count] * 0, every.names[:count], ("plate",)
    )
    settings = replace(QUICK, validation=validation)
    with pytest.raises(InputError, match=f"left to train on: 1; batch norm .*: {remedy}"):
        run(tmp_path / "run", settings, objects=few)
    if validation:
        run(tmp_path / "run", replace(settings, validation=False, epochs=1), objects=few)


@pytest.mark.parametrize(
    "wrong",
    [{"epochs": 0}, {"learning_rate": -1.0}, {"learning_rate": float("nan")}, {"mixing": 1.5}],
)
def test_values_out_of_range(wrong):
    with pytest.raises(CircumspectError, match=next(iter(wrong))):
        TrainingSettings(**wrong)


def test_two_processes_train_together(tmp_path):
    """As `torchrun` starts them, on the CPU."""
    script = tmp_path / "job.py"
    script.write_text(
        "import sys, pathlib\n"
        f"sys.path[:0] = {[str(folder) for folder in Path(__file__).parents[:2]]!r}\n"
        "import test_training as t\n"
        f"t.run(pathlib.Path({str(tmp_path / 'run')!r}), t.QUICK, stop_after=1)\n"
    )
    words = ["-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2", str(script)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "ACCELERATE_USE_CPU": "1"}
    done = subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, env=environment, timeout=300
    )
    assert done.returncode == 0, done.stderr[-2000:]
    with (tmp_path / "run" / "epochs.csv").open() as stream:
        assert len(list(csv.DictReader(stream))) == 1


def test_augmentation_is_part_of_the_cache_key(tmp_path):
    run(tmp_path / "a", stop_after=1)
    made = set((tmp_path / "grids").iterdir())
    run(tmp_path / "b", stop_after=1)
    assert set((tmp_path / "grids").iterdir()) == made
    other = TrainingSettings(
        epochs=3, batch_size=8, replicas=2, seed=1, augmentation=Augmentation(stretch=0.1)
    )
    run(tmp_path / "c", other, stop_after=1)
    assert len(set((tmp_path / "grids").iterdir())) == 2 * len(made)


class TestDraws:
    @given(seed=st.integers(0, 1000), sizes=st.lists(st.integers(1, 60), min_size=2, max_size=5))
    def test_balanced_draws_give_each_class_its_share(self, seed, sizes):
        labels = np.repeat(np.arange(len(sizes)), sizes)
        drawn = draw_epoch(class_chances(labels, 1.0), len(labels), np.random.default_rng(seed))
        counts = np.bincount(labels[drawn], minlength=len(sizes))
        assert len(drawn) == len(labels)
        assert np.abs(counts - len(labels) / len(sizes)).max() <= 1

    @given(seed=st.integers(0, 1000))
    def test_unbalanced_draws_show_every_object_once(self, seed):
        labels = np.repeat([0, 1, 2], [5, 50, 11])
        drawn = draw_epoch(class_chances(labels, 0.0), 66, np.random.default_rng(seed))
        assert sorted(drawn) == list(range(66))


def test_learning_rate_warms_up_peaks_and_decays():
    rates = [learning_rate_at(step, 200, 1e-3, 0.15) for step in range(200)]
    assert rates[0] == pytest.approx(1e-4)
    assert max(rates) == pytest.approx(1e-3)
    assert rates.index(max(rates)) == 30
    assert all(a >= b for a, b in pairwise(rates[30:]))
    assert rates[-1] < 2e-6


@given(st.integers(1, 5000))
def test_few_objects_are_shown_until_an_epoch_is_long_enough(count):
    passes = passes_for(count)
    assert passes * count >= MIN_DRAWS
    assert passes == 1 or (passes - 1) * count < MIN_DRAWS


def test_an_epoch_of_several_passes_takes_as_many_steps(tmp_path):
    steps = []

    class Counting(Silent):
        def stepped(self, epoch, step, of, loss):
            steps.append((step, of))

    settings = replace(QUICK, epochs=1, passes=3, validation=False)
    train(two_kinds(32), settings, tmp_path / "run", Counting(), GridCache(tmp_path / "grids"))
    assert steps == [(number, 12) for number in range(1, 13)]


def test_furniture_takes_its_share_of_the_draws(tmp_path, monkeypatch):
    """Procedural pieces are drawn besides, under the set's own class indices."""
    monkeypatch.setenv("CIRCUMSPECT_CACHE", str(tmp_path / "cache"))
    rng = np.random.default_rng(0)
    points = (rng.random((30, 300, 3)) - 0.5).astype(np.float32)
    labels = np.arange(30) % 2
    objects = ObjectSet(points, labels, np.array([f"x_{i}" for i in range(30)]), ("chair", "sofa"))
    settings = TrainingSettings(
        epochs=1, batch_size=8, replicas=1, furniture=0.5, furniture_each=2, validation=False
    )
    checkpoint = run(tmp_path / "run", settings, objects)
    assert checkpoint.classes == ("chair", "sofa")
    assert list((tmp_path / "cache" / "packs").glob("furniture-*-2-*.npz"))


def test_furniture_needs_known_classes(tmp_path):
    settings = TrainingSettings(epochs=1, batch_size=8, replicas=1, furniture=0.5)
    with pytest.raises(InputError, match="plate"):
        run(tmp_path / "run", settings)


def test_the_heading_is_learnt_at_zero_degrees_and_found_at_others(tmp_path):
    rng = np.random.default_rng(0)
    plain = two_kinds(96)
    # A rod sticks out along +x, so that every object has a front.
    rod = np.stack([rng.uniform(0.4, 1.2, (96, 60)), *rng.normal(0, 0.01, (2, 96, 60))], axis=2)
    clouds = np.concatenate([plain.points_xyz, rod.astype(np.float32)], axis=1)
    fronted = ObjectSet(clouds, plain.labels, plain.names, plain.classes)
    upright = Augmentation(mirror=0.0, holes=0.0)
    settings = TrainingSettings(
        net="headed-planes", epochs=8, batch_size=8, replicas=2, validation=False, heading=1.0,
        augmentation=upright,
    )  # fmt: skip
    checkpoint = run(tmp_path / "run", settings, fronted)
    net, input_spec = checkpoint.build(), checkpoint.input_spec
    quarter = input_spec.grids(fronted.cloud(0), [0.0, np.pi / 2])[:, 0]
    with torch.no_grad():
        columns = net.columns(torch.from_numpy(quarter).float().unsqueeze(1))
        ahead = net.facing(columns).squeeze(1).argmax(1).numpy()
    assert (ahead[0] + 1) % 32 <= 2
    assert (ahead[1] - ahead[0]) % 32 == 8
