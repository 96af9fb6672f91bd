"""What the model card promises is what was measured, and is so of the file that ships."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from circumspect.datasets import open_data_set
from circumspect.evaluation.predictor import load_predictor
from circumspect.evaluation.yaw_sweep import sweep_yaw

ROOT = Path(__file__).resolve().parent.parent
CARD = (ROOT / "docs" / "model-card.md").read_text()
METRICS = json.loads((ROOT / "benchmarks/results/modelnet10_test/metrics.json").read_text())


def test_the_bounds_hold_in_the_committed_figures() -> None:
    assert METRICS["weights"] == "shipped"
    assert METRICS["seen_in_training"] is False
    assert len(METRICS["yaw_deg"]) == 64
    assert METRICS["worst"] == min(METRICS["accuracy"])
    assert METRICS["spread"] <= 0.006
    assert METRICS["expected_calibration_error"] <= 0.03


def test_the_card_quotes_them() -> None:
    accuracy = METRICS["accuracy"]
    shown = (min(accuracy), sum(accuracy) / len(accuracy), max(accuracy))
    assert " / ".join(f"{100 * value:.1f} %" for value in shown) in CARD
    by_class = METRICS["mean_class_accuracy"]
    assert f"mean-class accuracy, mean | {100 * sum(by_class) / len(by_class):.1f} % |" in CARD
    assert f"| objects | {METRICS['objects']} |" in CARD
    assert f"label changes over yaw | {100 * METRICS['flip_rate']:.1f} % |" in CARD
    assert f"calibration error | {METRICS['expected_calibration_error']:.3f} |" in CARD


def test_the_file_that_ships_is_the_one_that_was_measured(data_folder: Path) -> None:
    test = open_data_set(data_folder / "modelnet10", "test")
    sweep = sweep_yaw(load_predictor(None), test, [0])
    # Eight bits are not rounded alike by all processors.
    assert sweep.accuracy[0] == pytest.approx(METRICS["accuracy"][0], abs=0.004)
