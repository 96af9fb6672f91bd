"""Training whose loss or weights are no longer finite."""

from dataclasses import replace
from importlib import import_module

import pytest
from quick_run import QUICK, run

from circumspect.errors import InputError
from circumspect.training.draws import learning_rate_at


def test_a_diverging_training_is_reported_and_keeps_no_weights(tmp_path):
    settings = replace(QUICK, optimizer="sgd", learning_rate=1e30, gradient_norm=1e30)
    with pytest.raises(InputError, match=r"the loss is (nan|inf) in epoch 1: .*--learning-rate"):
        run(tmp_path / "run", settings)
    assert not (tmp_path / "run" / "best.safetensors").exists()


@pytest.mark.parametrize("averaging", [0.0, 0.9])
def test_a_last_step_that_breaks_the_weights_keeps_the_epoch_before(
    tmp_path, monkeypatch, averaging
):
    settings = replace(QUICK, optimizer="sgd", averaging=averaging)
    folder = tmp_path / "run"
    run(folder, settings, stop_after=1)
    files = ("best.safetensors", "state.safetensors", "epochs.csv")
    before = {name: (folder / name).read_bytes() for name in files}

    def broken(step, steps, *arguments):
        ends_epoch_2 = step + 1 == 2 * steps // settings.epochs
        return float("nan") if ends_epoch_2 else learning_rate_at(step, steps, *arguments)

    monkeypatch.setattr(import_module("circumspect.training.train"), "learning_rate_at", broken)
    with pytest.raises(InputError, match=r"is no longer finite after epoch 2: .*--learning-rate"):
        run(folder, settings)
    assert before == {name: (folder / name).read_bytes() for name in files}
