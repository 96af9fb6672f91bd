"""Calibration of probabilities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.evaluation.calibration import (
    BINS,
    fitted_temperature,
    known_within,
    reliability,
    tempered,
)


def honest(count=40_000, classes=5, sharpness=3.0, seed=0):
    """Answers whose probabilities are those of the truth."""
    rng = np.random.default_rng(seed)
    probabilities = tempered(rng.dirichlet(np.ones(classes), count), 1 / sharpness)
    cumulative = probabilities.cumsum(axis=1)
    labels = (rng.random((count, 1)) > cumulative).sum(axis=1).clip(max=classes - 1)
    return probabilities, labels


def test_calibrated_probabilities_have_no_calibration_error():
    assert reliability(*honest()).expected_error < 0.01


@pytest.mark.parametrize("temperature", [0.5, 2.0])
def test_the_temperature_that_was_applied_is_found_and_undone(temperature):
    probabilities, labels = honest()
    bent = tempered(probabilities, temperature)
    assert reliability(bent, labels).expected_error > 0.05
    found = fitted_temperature(bent, labels)
    assert found == pytest.approx(1 / temperature, rel=0.05)
    assert reliability(tempered(bent, found), labels).expected_error < 0.015


def test_errors_agree_with_a_computation_by_hand():
    probabilities = np.array([[0.9, 0.1], [0.9, 0.1], [0.3, 0.7], [0.55, 0.45]])
    labels = np.array([0, 1, 1, 0])
    found = reliability(probabilities, labels)
    assert found.counts.sum() == 4
    assert found.expected_error == pytest.approx((2 * 0.4 + 0.3 + 0.45) / 4)


@given(st.integers(1, 50), st.integers(2, 6), st.integers(0, 2**20))
def test_every_answer_is_in_one_bin_and_the_error_is_a_share(count, classes, seed):
    rng = np.random.default_rng(seed)
    probabilities = rng.dirichlet(np.ones(classes), count)
    found = reliability(probabilities, rng.integers(classes, size=count))
    assert found.counts.sum() == count
    assert len(found.counts) == BINS
    assert 0 <= found.expected_error <= 1
    held = found.counts > 0
    assert (found.confidence[held] >= found.edges[:-1][held] - 1e-12).all()
    assert (found.confidence[held] <= found.edges[1:][held] + 1e-12).all()


@given(st.floats(0.2, 5.0), st.integers(0, 2**20))
def test_a_temperature_changes_no_answer(temperature, seed):
    probabilities = np.random.default_rng(seed).dirichlet(np.ones(4), 30)
    bent = tempered(probabilities, temperature)
    np.testing.assert_array_equal(bent.argmax(axis=1), probabilities.argmax(axis=1))
    np.testing.assert_allclose(bent.sum(axis=1), 1)
    np.testing.assert_allclose(tempered(bent, 1 / temperature), probabilities, atol=1e-6)


def test_the_given_share_of_known_objects_reaches_the_threshold():
    distances = np.random.default_rng(0).random(1000)
    assert (distances <= known_within(distances)).mean() == pytest.approx(0.95, abs=2e-3)


def test_without_errors_there_is_no_best_temperature():
    with pytest.raises(InputError, match="correct answers and wrong ones"):
        fitted_temperature(np.array([[0.8, 0.2], [0.3, 0.7]]), np.array([0, 1]))
