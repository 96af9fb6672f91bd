"""A training whose loss is no number any more."""

from dataclasses import replace

import pytest
from quick_run import QUICK, run

from circumspect.errors import InputError


def test_a_training_that_diverges_says_so_and_keeps_no_weights(tmp_path):
    settings = replace(QUICK, optimizer="sgd", learning_rate=1e30, gradient_norm=1e30)
    with pytest.raises(InputError, match=r"the loss is (nan|inf) in epoch 1: .*--learning-rate"):
        run(tmp_path / "run", settings)
    assert not (tmp_path / "run" / "best.safetensors").exists()
