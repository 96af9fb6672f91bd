"""Bounds of confidence and the open-set model, fitted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.evaluation.confidence_fit import (
    MIN_ANSWERS,
    NEVER,
    fitted_confidence,
    fitted_open_set,
    least_probability,
)


def answers(count, seed, sharpness=4.0):
    """Answers that are correct as often as their probability says, or more often."""
    rng = np.random.default_rng(seed)
    probability = rng.random(count) ** (1 / sharpness)
    return probability, rng.random(count) < probability, rng


@given(count=st.integers(0, 300), seed=st.integers(0, 50), most=st.floats(0.0, 0.3))
def test_above_the_bound_at_most_the_given_share_is_wrong(count, seed, most):
    probability, correct, _ = answers(count, seed)
    bound = least_probability(probability, correct, most)
    above = probability >= bound
    if bound < NEVER:
        assert above.sum() >= MIN_ANSWERS
        assert (~correct[above]).mean() <= most
    else:
        assert not above.any()


def test_equal_probabilities_are_taken_together():
    probability = np.full(100, 0.9)
    correct = np.arange(100) < 90
    assert least_probability(probability, correct, 0.02) == NEVER
    assert least_probability(probability, correct, 0.11) == 0.9


def test_answers_count_by_their_weight():
    probability = np.concatenate([np.full(100, 0.9), np.full(100, 0.8)])
    correct = np.ones(200, bool)
    correct[[0, 110, 120, 130, 140]] = False
    assert least_probability(probability, correct, 0.02) == 0.9
    heavy = np.where(probability == 0.9, 4.0, 1.0)
    assert least_probability(probability, correct, 0.02, heavy) == 0.8
    np.testing.assert_allclose(
        least_probability(probability, correct, 0.02, np.full(200, 7.0)),
        least_probability(probability, correct, 0.02),
    )


def test_bounds_do_not_rise_with_the_coverage():
    probability, correct, rng = answers(4000, 3, sharpness=8.0)
    coverage = rng.random(4000)
    # At low coverage the answers are worse than their probabilities.
    correct &= rng.random(4000) < 0.8 + 0.2 * coverage
    rule = fitted_confidence(probability, correct, coverage, 0.95, max_error_rate=0.05)
    assert list(rule.probability) == sorted(rule.probability, reverse=True)
    assert rule.without_coverage == 0.95
    confident = np.array(
        [not rule.reason(p, c) for p, c in zip(probability, coverage, strict=True)]
    )
    assert confident.any()
    assert (~correct[confident]).mean() <= 0.06


def test_bins_with_few_answers_are_not_confident():
    probability, correct, _ = answers(10, 0)
    rule = fitted_confidence(probability, correct, np.full(10, 0.25), NEVER)
    assert rule.bound(0.25) == NEVER
    assert rule.reason(1.0, 0.25)


def test_the_open_set_model_separates_by_both_signs():
    rng = np.random.default_rng(0)
    known = np.arange(400) < 300
    other = np.where(known, rng.beta(1, 6, 400), rng.beta(3, 2, 400))
    distance = np.where(known, rng.uniform(0.01, 0.1, 400), rng.uniform(0.05, 0.4, 400))
    rule = fitted_open_set(other, distance, known)
    belongs = rule.probability(other, distance)
    assert rule.other < 0
    assert rule.distance < 0
    assert (belongs[known] >= rule.threshold).mean() == pytest.approx(0.95, abs=0.02)
    assert (belongs[~known] >= rule.threshold).mean() < 0.5


def test_kinds_that_separate_still_give_finite_factors():
    known = np.arange(40) < 20
    rule = fitted_open_set(np.where(known, 0.0, 1.0), None, known)
    assert np.isfinite([rule.bias, rule.other, rule.threshold]).all()


@pytest.mark.parametrize("known", [np.ones(5, bool), np.zeros(5, bool)])
def test_objects_of_one_kind_make_no_open_set(known):
    with pytest.raises(InputError, match="other kinds"):
        fitted_open_set(np.full(5, 0.5), None, known)
