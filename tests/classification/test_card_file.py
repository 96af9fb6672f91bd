"""The figures beside a classifier's weights round-trip, and broken files are known errors."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification import SHIPPED, shipped_path
from circumspect.classification.model_card import (
    NETWORK_TIME,
    SHARE,
    CardFigure,
    ModelCard,
    card_path,
)
from circumspect.classification.model_facts import ModelFacts, setting_text
from circumspect.errors import InputError

FIGURE = CardFigure("accuracy", 0.925, SHARE, "a set", "circumspect evaluate", headline=True)
LINES = st.text(st.characters(categories=["L", "N", "P"]), max_size=30)


@given(
    figures=st.lists(
        st.builds(
            CardFigure, LINES, st.floats(allow_nan=False, allow_infinity=False), LINES, LINES,
            LINES, LINES, st.booleans(),
        )
    )
)  # fmt: skip
def test_a_card_round_trips(
    tmp_path_factory: pytest.TempPathFactory, figures: list[CardFigure]
) -> None:
    file = tmp_path_factory.mktemp("cards") / "own.card.json"
    card = ModelCard("f" * 64, tuple(figures))
    card.save(file)
    assert ModelCard.load(file) == card


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.92511, SHARE, "92.5 %"), (1.0, SHARE, "100.0 %"), (23.424, "ms", "23.4 ms"),
        (0.02711, "", "0.0271"), (7, "mm", "7 mm"),
    ],
)  # fmt: skip
def test_a_figure_is_shown_with_its_unit(value: float, unit: str, text: str) -> None:
    assert CardFigure("m", value, unit, "d", "c").text == text


def test_time_and_headlines_are_found() -> None:
    time = CardFigure(NETWORK_TIME, 23.4, "ms", "1 thread", "c")
    card = ModelCard("f" * 64, (FIGURE, time))
    assert card.network_time == time
    assert card.headlines == (FIGURE,)
    assert ModelCard("f" * 64, ()).network_time is None


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "not a model card in JSON"),
        ("[]", "format 1"),
        ('{"format": 2}', "format 1"),
        ('{"format": 1}', "needs a text 'sha256'"),
        ('{"format": 1, "sha256": "0", "figures": {}}', "a list 'figures'"),
        ('{"format": 1, "sha256": "0", "figures": [7]}', "must be an object"),
        ('{"format": 1, "sha256": "0", "figures": [{"measure": "a"}]}', "needs 'value'"),
        ("[" * 100_000, "not a model card in JSON"),
    ],
)
def test_broken_cards_are_known_errors(tmp_path: Path, content: str, message: str) -> None:
    file = tmp_path / "own.card.json"
    file.write_text(content)
    with pytest.raises(InputError, match=message) as error:
        ModelCard.load(file)
    assert str(error.value).startswith(f"{file}: ")


@pytest.mark.parametrize(
    "change",
    [
        {"value": "0.9"}, {"value": True}, {"value": math.nan}, {"value": math.inf}, {"unit": 1},
        {"measure": "two\nlines"}, {"data": "\x1b[2J"}, {"command": "x" * 301},
        {"headline": "yes"}, {"colour": "red"},
    ],
)  # fmt: skip
def test_broken_figures_are_known_errors(tmp_path: Path, change: dict) -> None:
    figure = {"measure": "m", "value": 1.0, "unit": "", "data": "d", "command": "c", **change}
    file = tmp_path / "own.card.json"
    file.write_text(json.dumps({"format": 1, "sha256": "0", "figures": [figure]}))
    with pytest.raises(InputError, match=r"own\.card\.json: "):
        ModelCard.load(file)


def test_missing_and_large_cards(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        ModelCard.load(tmp_path / "none.card.json")
    with (tmp_path / "large.card.json").open("wb") as stream:
        stream.truncate(2**30)
    with pytest.raises(InputError, match="larger than 1 MiB"):
        ModelCard.load(tmp_path / "large.card.json")


def test_figures_of_another_file_are_stale(tmp_path: Path) -> None:
    own = tmp_path / "own.onnx"
    own.write_bytes(shipped_path("modelnet10").read_bytes())
    facts = ModelFacts.load(own)
    assert (facts.card, facts.stale, facts.shipped) == (None, False, None)
    card = ModelCard(facts.sha256, (FIGURE,))
    card.save(card_path(own))
    assert ModelFacts.load(own).card == card
    ModelCard("0" * 64, (FIGURE,)).save(card_path(own))
    again = ModelFacts.load(own)
    assert (again.card, again.stale) == (None, True)


@pytest.mark.parametrize("name", SHIPPED)
def test_facts_of_shipped_classifiers_are_json(name: str) -> None:
    facts = ModelFacts.load(name)
    record = json.loads(json.dumps(facts.to_dict()))
    assert record["name"] == name
    assert record["bytes"] == shipped_path(name).stat().st_size
    assert record["classes"] == list(facts.classifier.classes)
    assert not facts.stale, "run its benchmark again: the card is of another file"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "yes"), (False, "no"), (0.10, "0.1"), (8, "8"), ([32, 32, 32], "32 x 32 x 32"),
        ([0.95, 1.15], "0.95, 1.15"), ({"a": 1, "b": [2]}, "a 1, b 2"), ("fp32", "fp32"),
    ],
)  # fmt: skip
def test_settings_are_readable(value: object, text: str) -> None:
    assert setting_text(value) == text
