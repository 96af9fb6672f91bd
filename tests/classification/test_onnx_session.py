"""Many inputs are given to a network a few at a time."""

from collections import namedtuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification import Classifier
from circumspect.classification.onnx_session import (
    MAX_BATCH_INPUTS,
    MAX_BATCH_NUMBERS,
    run_in_parts,
)
from circumspect.errors import WeightsError

Value = namedtuple("Value", "name")


class Sums:
    """Returns the sum of each input, and records the number of inputs of each call."""

    def __init__(self, widths=(1,)):
        self.sizes, self.widths = [], widths

    def get_inputs(self):
        return [Value("given")]

    def get_outputs(self):
        return [Value("sum")]

    def run(self, wanted, given):
        assert wanted == ["sum"]
        inputs = given["given"]
        width = self.widths[len(self.sizes) % len(self.widths)]
        self.sizes.append(len(inputs))
        sums = inputs.reshape(len(inputs), -1).sum(axis=1, dtype=np.float32)
        return [np.repeat(sums[:, None], width, axis=1)]


@given(count=st.integers(1, 300), side=st.sampled_from([1, 8, 32, 48]))
def test_batches_give_the_result_of_the_whole_and_are_bounded(count, side):
    inputs = np.broadcast_to(np.arange(count, dtype=np.float32)[:, None], (count, side**3))
    network = Sums()
    (found,) = run_in_parts(network, inputs, ["sum"])
    np.testing.assert_array_equal(found[:, 0], inputs.sum(axis=1, dtype=np.float32))
    assert max(network.sizes) <= MAX_BATCH_INPUTS
    assert max(network.sizes) * side**3 <= MAX_BATCH_NUMBERS
    assert len(network.sizes) <= np.ceil(
        count / min(MAX_BATCH_INPUTS, MAX_BATCH_NUMBERS // side**3)
    )


def test_an_input_larger_than_a_batch_is_run_alone():
    network = Sums()
    run_in_parts(network, np.zeros((3, MAX_BATCH_NUMBERS + 1), np.uint8), ["sum"])
    assert network.sizes == [1, 1, 1]


def test_a_network_that_gives_rows_of_two_widths():
    with pytest.raises(WeightsError, match="now more, now fewer"):
        run_in_parts(Sums(widths=(1, 2)), np.zeros((MAX_BATCH_INPUTS + 1, 1)), ["sum"])


def test_many_yaws_and_views_are_named_as_one_by_one():
    classifier = Classifier.load("modelnet10", threads=1)
    rng = np.random.default_rng(0)
    grids = (rng.random((20, 4, *classifier.input_spec.input_shape)) < 0.05).astype(np.uint8)
    alone = np.concatenate([classifier.probabilities(grid[None]) for grid in grids])
    np.testing.assert_allclose(classifier.probabilities(grids), alone, atol=1e-5)
