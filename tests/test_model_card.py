"""The figures of the model cards are those measured on the shipped files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from benchmarks import card_figures
from benchmarks.model_cards import TEXTS, ModelText, page, pages

from circumspect.classification import SHIPPED, shipped_path
from circumspect.classification.context import WIDTH
from circumspect.classification.model_card import ModelCard, card_path
from circumspect.classification.model_facts import ModelFacts
from circumspect.datasets import open_data_set
from circumspect.evaluation.predictor import load_predictor
from circumspect.evaluation.yaw_sweep import sweep_yaw

ROOT = Path(__file__).resolve().parent.parent
METRICS = json.loads((ROOT / "benchmarks/results/modelnet10_test/metrics.json").read_text())
WEIGHTS = sorted(shipped_path("modelnet10").parent.iterdir())


def test_the_bounds_hold_in_the_committed_figures() -> None:
    assert METRICS["model"] == "modelnet10"
    assert METRICS["seen_in_training"] is False
    assert len(METRICS["yaw_deg"]) == 64
    assert METRICS["worst"] == min(METRICS["accuracy"])
    assert METRICS["spread"] <= 0.006
    assert METRICS["expected_calibration_error"] <= 0.03


def test_the_card_of_modelnet10_quotes_them() -> None:
    card = (ROOT / "docs" / "models" / "modelnet10.md").read_text()
    accuracy, by_class = METRICS["accuracy"], METRICS["mean_class_accuracy"]
    for measure, value in (
        ("accuracy, mean over 64 yaws", sum(accuracy) / len(accuracy)),
        ("accuracy, worst of 64 yaws", min(accuracy)),
        ("accuracy, best of 64 yaws", max(accuracy)),
        ("mean-class accuracy, mean over 64 yaws", sum(by_class) / len(by_class)),
        ("objects whose label changes over 64 yaws", METRICS["flip_rate"]),
    ):
        assert f"| {measure} | {100 * value:.1f} % |" in card
    assert f"calibration error | {METRICS['expected_calibration_error']:.3g} |" in card
    assert f"ModelNet10 test, {METRICS['objects']} objects" in card


def test_the_file_that_ships_is_the_one_that_was_measured(data_folder: Path) -> None:
    test = open_data_set(data_folder / "modelnet10", "test")
    sweep = sweep_yaw(load_predictor("modelnet10"), test, [0])
    # Eight bits are not rounded alike by all processors.
    assert sweep.accuracy[0] == pytest.approx(METRICS["accuracy"][0], abs=0.004)


@pytest.mark.parametrize("name", card_figures.CARDS)
def test_cards_beside_weights_hold_the_committed_results(name: str) -> None:
    beside = card_path(shipped_path(name))
    assert card_figures.is_current(name, beside), f"run: python -m benchmarks.card_figures {name}"
    assert ModelCard.load(beside).sha256 == ModelFacts.load(name).sha256


def test_generated_cards_are_up_to_date() -> None:
    for file, text in pages().items():
        assert file.is_file(), "run: python -m benchmarks.model_cards"
        assert file.read_text(encoding="utf-8") == text, "run: python -m benchmarks.model_cards"


@pytest.mark.parametrize("file", WEIGHTS, ids=lambda file: file.name)
def test_files_beside_weights_are_small(file: Path) -> None:
    assert file.stat().st_size <= 8_000_000


@pytest.mark.parametrize("name", SHIPPED)
def test_no_measured_figure_is_written_by_hand(name: str) -> None:
    text = (TEXTS / f"{name}.json").read_text(encoding="utf-8")
    # A bound that the program has is no measured figure.
    shares = set(re.findall(r"\d+(?:\.\d+)? %", text)) - {"4 %"}
    assert not shares, f"give these as figures of the card: {sorted(shares)}"


@pytest.mark.parametrize("shipped", SHIPPED)
def test_the_size_of_the_network_is_that_of_its_file(shipped: str) -> None:
    pytest.importorskip("torch", reason="needs the extra train")
    from circumspect.nets import build_net, cost_of

    classifier = ModelFacts.load(shipped).classifier
    input_spec, outputs = (
        classifier.input_spec,
        len(classifier.classes) + (classifier.other is not None),
    )
    net = build_net(classifier.description["name"], outputs, input_spec)
    if input_spec.takes_context:
        # Occupied and free cells are a channel each.
        cost = cost_of(net, (2, *input_spec.input_shape[1:]), WIDTH)
    else:
        cost = cost_of(net, input_spec.input_shape)
    size = ModelText.load(TEXTS / f"{shipped}.json").properties["size"]
    assert size.startswith(f"{cost.parameters:,} parameters, {cost.multiply_adds / 1e6:.0f} M ")


def test_a_card_names_the_creators_of_what_it_was_trained_on() -> None:
    facts = ModelFacts.load("modelnet10")
    assert "## Attributions" not in page(facts, ModelText())
    work = {"work": "Sofa | bed", "creator": "A. Smith", "licence": "CC BY 4.0", "source": "a page"}
    card = page(facts, ModelText(attributions=[work]))
    assert "## Attributions" in card
    assert "| Sofa \\| bed | A. Smith | CC BY 4.0 | a page |" in card


def test_a_card_without_figures_shows_a_dash(tmp_path: Path) -> None:
    facts = ModelFacts.load("modelnet10")
    object.__setattr__(facts, "card", None)
    assert "## Figures\n\n–" in page(facts, ModelText())


def test_a_text_with_an_unknown_entry_is_refused(tmp_path: Path) -> None:
    (tmp_path / "own.json").write_text('{"limit": []}')
    with pytest.raises(ValueError, match=r"own\.json: unknown \['limit'\]; known: \['attributions"):
        ModelText.load(tmp_path / "own.json")
