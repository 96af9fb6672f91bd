"""Runs of seconds, for tests."""

from __future__ import annotations

from dataclasses import replace

from two_kinds import two_kinds

from circumspect.datasets import GridCache
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings
from circumspect.training.train import train

QUICK = TrainingSettings(epochs=3, batch_size=8, replicas=2, seed=1)


class Silent:
    """Receives the progress and prints nothing."""

    def preparing(self, done, total):
        pass

    def stepped(self, epoch, step, steps, loss):
        pass

    def finished_epoch(self, row):
        pass


def run(folder, settings=QUICK, objects=None, observer=None, **options):
    cache = GridCache(folder.parent / "grids")
    return train(objects or two_kinds(), settings, folder, observer or Silent(), cache, **options)


def as_meant(net, **changes):
    """Settings for a network that is trained in its own way."""
    return replace(QUICK, **{**net_spec(net).training, "net": net, "replicas": 2, **changes})
