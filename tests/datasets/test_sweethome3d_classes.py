"""Classes from names, categories and sizes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets.mesh_pack import AMBIGUOUS, OTHER, read_mesh_pack
from circumspect.datasets.sweethome3d_classes import (
    CLASSES,
    NEVER_FURNITURE,
    RULES,
    has_furniture_size,
    label_of,
)

UPRIGHT, LOW, LONG = (0.5, 0.5, 0.9), (0.8, 0.8, 0.7), (2.0, 0.9, 0.8)


@pytest.mark.parametrize(
    ("name", "category", "metres", "answer"),
    [
        ("Chair", "Living room", UPRIGHT, "chair"),
        ("Folding chairs", "Exterior", UPRIGHT, "chair"),
        ("Class seat", "Office", UPRIGHT, "chair"),
        ("Desk chair", "Office", UPRIGHT, "chair"),
        ("Armchair", "Office", UPRIGHT, "chair"),
        ("Sofa 2 seats", "Living room", LONG, "sofa"),
        ("Futon couch", "Living room", LONG, "sofa"),
        ("Captain's bed", "Bedroom", LONG, "bed"),
        ("BED 90x190", "Bedroom", LONG, "bed"),
        ("Bedside table", "Bedroom", (0.4, 0.4, 0.5), "night_stand"),
        ("Chest", "Bedroom", LONG, "dresser"),
        ("Dresser with drawers", "Living room", LONG, "dresser"),
        ("Desk table", "Office", LONG, "desk"),
        ("Table with tablecloth", "Living room", LONG, "table"),
        ("Flat TV", "Living room", (1.2, 0.3, 0.8), "monitor"),
        ("Fitted bath", "Bathroom", LONG, "bathtub"),
        ("Toilets unit", "Bathroom", UPRIGHT, "toilet"),
        ("Armchair", "Living room", UPRIGHT, "ambiguous"),
        ("Armchair", "Office", LOW, "ambiguous"),
        ("Chair", "Exterior", LOW, "ambiguous"),
        ("Child chair", "Bedroom", (0.2, 0.2, 0.4), "ambiguous"),
        ("Chair", "Bedroom", (0.05, 0.05, 0.1), "ambiguous"),
        ("Bed", "Bedroom", (14.0, 20.0, 7.0), "ambiguous"),
        ("Bar chair", "Kitchen", UPRIGHT, "ambiguous"),
        ("Baby bed", "Bedroom", LONG, "ambiguous"),
        ("Pool table", "Miscellaneous", LONG, "ambiguous"),
        ("TV stand", "Living room", LONG, "ambiguous"),
        ("Box", "Office", LONG, "ambiguous"),
        ("Box", "Miscellaneous", LONG, "other"),
        ("Table lamp", "Lights", UPRIGHT, "other"),
        ("Toilet brush", "Bathroom", UPRIGHT, "other"),
        ("Chest freezer", "Kitchen", LOW, "other"),
        ("Tablet", "Miscellaneous", LOW, "other"),
        ("Bathroom cabinet", "Bathroom", LONG, "other"),
        ("Seat Leon", "Vehicles", UPRIGHT, "other"),
        ("Wardrobe", "Bedroom", UPRIGHT, "other"),
        ("", "", LOW, "other"),
    ],
)
def test_answers(name, category, metres, answer):
    expected = {"other": OTHER, "ambiguous": AMBIGUOUS}
    assert label_of(name, category, metres) == (
        expected[answer] if answer in expected else CLASSES.index(answer)
    )


@pytest.mark.parametrize(
    ("category", "metres", "furniture"),
    [
        ("Bedroom", (0.1, 0.1, 0.3), True),
        ("Bedroom", (0.1, 0.1, 0.29), False),
        ("Bedroom", (3.5, 0.1, 0.3), True),
        ("Bedroom", (3.51, 0.1, 0.3), False),
        ("Bedroom", (1.0, 0.03, 1.0), True),
        ("Bedroom", (1.0, 0.029, 1.0), False),
        *((category, (0.5, 0.5, 0.5), False) for category in NEVER_FURNITURE),
    ],
)
def test_furniture_size(category, metres, furniture):
    assert has_furniture_size(category, metres) is furniture


def test_every_answer_of_the_table_is_known_and_every_class_has_a_row():
    answers = {rule.answer for rule in RULES}
    assert answers == {*CLASSES, "other", "ambiguous"}


@given(st.text(max_size=30), st.text(max_size=10), st.tuples(*[st.floats(1e-3, 100)] * 3))
def test_only_pieces_of_the_size_of_furniture_have_a_class(name, category, metres):
    for words in (name, f"{name} chair", f"bed {name}"):
        label = label_of(words, category, metres)
        assert AMBIGUOUS <= label < len(CLASSES)
        assert label < 0 or has_furniture_size(category, metres)


def test_agreement_with_the_development_data(data_folder):
    path = data_folder / "sweethome3d" / "meshes.npz"
    if not path.is_file():
        pytest.skip(f"no {path}")
    meshes = read_mesh_pack(path)
    assert meshes.classes == CLASSES
    labels = sizes = 0
    for index in range(len(meshes)):
        entry = meshes.entry(index)
        metres = tuple(round(side, 5) for side in entry.metres)
        labels += label_of(entry.title, entry.category, metres) == entry.label
        sizes += has_furniture_size(entry.category, metres) == entry.furniture_size
    assert sizes == len(meshes)
    assert labels / len(meshes) > 0.99
