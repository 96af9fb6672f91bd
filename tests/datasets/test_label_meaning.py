"""Which labels are classes, which are other kinds, and which say too little."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets.label_meaning import (
    AMBIGUOUS,
    SYNONYMS,
    UNLABELLED,
    LabelUse,
    meaning_of,
    plain_label,
)
from circumspect.furniture import CATEGORIES

PAGE = Path(__file__).resolve().parents[2] / "docs" / "real-objects.md"


@pytest.mark.parametrize(
    ("label", "true_class"),
    [
        *((name, name) for name in CATEGORIES),
        ("Night Stand", "night_stand"),
        ("night-stand", "night_stand"),
        ("nightstand", "night_stand"),
        ("couch", "sofa"),
        ("Coffee table", "table"),
    ],
)
def test_classes_and_synonyms_are_known(label, true_class):
    meaning = meaning_of(label, CATEGORIES)
    assert meaning.use is LabelUse.KNOWN_CLASS
    assert meaning.true_class == true_class


@pytest.mark.parametrize(
    "label", ["cabinet", "shelf", "cart", "lamp", "trash_bin", "otherfurniture", "bench", "stool"]
)
def test_other_kinds(label):
    assert meaning_of(label, CATEGORIES).use is LabelUse.OTHER_KIND


@pytest.mark.parametrize("label", ["armchair", "Sofa chair", "end_table", "tv", "unknown"])
def test_ambiguous_labels_are_left_out(label):
    assert meaning_of(label, CATEGORIES).use is LabelUse.LEFT_OUT


def test_a_class_takes_precedence_over_the_tables():
    own = ("armchair", "couch", "Mug")
    for label in ("armchair", "couch", "mug"):
        assert meaning_of(label, own).use is LabelUse.KNOWN_CLASS
    assert meaning_of("mug", own).true_class == "Mug"


def test_without_the_classes_that_it_may_stand_for_a_label_is_another_kind():
    assert meaning_of("armchair", ("mug", "plate")).use is LabelUse.OTHER_KIND
    assert meaning_of("couch", ("mug", "plate")).use is LabelUse.OTHER_KIND
    assert meaning_of("unknown", ("mug", "plate")).use is LabelUse.LEFT_OUT


@given(st.text(), st.lists(st.text(min_size=1), min_size=1))
def test_every_label_has_one_meaning(label, classes):
    meaning = meaning_of(label, classes)
    assert (meaning.use is LabelUse.KNOWN_CLASS) == (meaning.true_class in classes)
    assert meaning_of(classes[0], classes).use is LabelUse.KNOWN_CLASS


def test_tables_do_not_contradict_each_other():
    words = [*SYNONYMS, *AMBIGUOUS, *UNLABELLED, *CATEGORIES]
    assert len(set(words)) == len(words)
    assert all(plain_label(word) == word for word in words)
    assert set(SYNONYMS.values()) | {n for names in AMBIGUOUS.values() for n in names} <= set(
        CATEGORIES
    )


def test_the_documentation_lists_both_tables():
    text = PAGE.read_text(encoding="utf-8")
    for label in (*SYNONYMS, *AMBIGUOUS, *UNLABELLED):
        assert f"`{label}`" in text, label
