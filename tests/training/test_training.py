import csv
import json
from itertools import pairwise

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets import Augmentation, GridCache, ObjectSet
from circumspect.errors import InputError, WeightsError
from circumspect.nets import Checkpoint
from circumspect.training import TrainingSettings, train
from circumspect.training.draws import class_chances, draw_epoch, learning_rate_at

QUICK = TrainingSettings(epochs=3, batch_size=8, replicas=2, seed=1)


class Silent:
    def preparing(self, done, total):
        pass

    def stepped(self, epoch, step, steps, loss):
        pass

    def finished_epoch(self, row):
        pass


def shapes(count=48, points=300, seed=0):
    """Two classes that anyone can tell apart: flat plates and upright posts."""
    rng = np.random.default_rng(seed)
    cube = rng.random((count, points, 3)) - 0.5
    labels = np.arange(count) % 2
    size = np.where(labels[:, None] == 0, [1.0, 1.0, 0.1], [0.15, 0.15, 1.0])
    clouds = (cube * size[:, None]).astype(np.float32)
    names = np.array([f"{['plate', 'post'][k]}_{i:04d}" for i, k in enumerate(labels)])
    return ObjectSet(clouds, labels.astype(np.int64), names, ("plate", "post"))


def run(folder, settings=QUICK, objects=None, **options):
    cache = GridCache(folder.parent / "grids")
    return train(objects or shapes(), settings, folder, Silent(), cache, **options)


def test_learns_logs_and_keeps_the_best(tmp_path):
    settings = TrainingSettings(epochs=6, batch_size=8, replicas=2, seed=1)
    checkpoint = run(tmp_path / "run", settings, shapes(96))
    assert checkpoint.classes == ("plate", "post")
    assert checkpoint.training["reached"]["validation_accuracy"] == 1.0
    with (tmp_path / "run" / "epochs.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["epoch"] for row in rows] == ["1", "2", "3", "4", "5", "6"]
    assert float(rows[-1]["loss"]) < float(rows[0]["loss"])
    written = json.loads((tmp_path / "run" / "config.json").read_text())
    assert written["settings"]["seed"] == 1
    assert list((tmp_path / "run" / "tensorboard").iterdir())


def test_resumed_run_equals_an_uninterrupted_one(tmp_path):
    whole = run(tmp_path / "whole")
    run(tmp_path / "parts", stop_after=1)
    resumed = run(tmp_path / "parts")
    assert whole.weights.keys() == resumed.weights.keys()
    for name, value in whole.weights.items():
        torch.testing.assert_close(resumed.weights[name], value, rtol=0, atol=0)


def test_killed_within_an_epoch_it_starts_that_epoch_again(tmp_path):
    class Killer(Silent):
        def stepped(self, epoch, step, steps, loss):
            if epoch == 1 and step == 2:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(shapes(), QUICK, tmp_path / "run", Killer(), GridCache(tmp_path / "grids"))
    resumed, whole = run(tmp_path / "run"), run(tmp_path / "whole")
    for name, value in whole.weights.items():
        torch.testing.assert_close(resumed.weights[name], value, rtol=0, atol=0)


def test_other_settings_are_not_mixed_in(tmp_path):
    run(tmp_path / "run", stop_after=1)
    with pytest.raises(InputError, match="other settings"):
        run(tmp_path / "run", TrainingSettings(epochs=4, batch_size=8, replicas=2, seed=1))
    with pytest.raises(InputError, match="other settings"):
        run(tmp_path / "run", objects=shapes(seed=5))


def test_broken_state_is_named(tmp_path):
    run(tmp_path / "run", stop_after=1)
    state = tmp_path / "run" / "state.safetensors"
    state.write_bytes(state.read_bytes()[:1000])
    with pytest.raises(WeightsError, match=r"state\.safetensors"):
        run(tmp_path / "run")


def test_without_validation_all_objects_train_and_the_last_epoch_is_kept(tmp_path):
    settings = TrainingSettings(epochs=2, batch_size=8, replicas=1, validation=False)
    checkpoint = run(tmp_path / "run", settings)
    assert checkpoint.training["reached"]["epoch"] == 2
    assert "validation_accuracy" not in checkpoint.training["reached"]


def test_bf16_trains(tmp_path):
    settings = TrainingSettings(epochs=2, batch_size=8, replicas=2, precision="bf16", seed=1)
    checkpoint = run(tmp_path / "run", settings)
    assert np.isfinite(checkpoint.training["reached"]["loss"])
    assert all(v.dtype != torch.bfloat16 for v in checkpoint.weights.values())


def test_a_class_without_objects_is_named(tmp_path):
    objects = shapes()
    three = ObjectSet(objects.points_xyz, objects.labels, objects.names, ("plate", "post", "urn"))
    with pytest.raises(InputError, match="urn"):
        run(tmp_path / "run", objects=three)


def test_checkpoint_is_the_one_on_disk(tmp_path):
    given_back = run(tmp_path / "run")
    loaded = Checkpoint.load(tmp_path / "run" / "best.safetensors")
    for name, value in loaded.weights.items():
        torch.testing.assert_close(value, given_back.weights[name], rtol=0, atol=0)


def test_augmentation_belongs_to_the_cache_key(tmp_path):
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
