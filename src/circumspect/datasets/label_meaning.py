"""Meaning of a real object's label to a classifier: one of its classes, or another kind."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

SYNONYMS: Mapping[str, str] = MappingProxyType(
    {
        "bath": "bathtub",
        "bath_tub": "bathtub",
        "bedside_table": "night_stand",
        "bunk_bed": "bed",
        "coffee_table": "table",
        "computer_monitor": "monitor",
        "conference_table": "table",
        "couch": "sofa",
        "desk_chair": "chair",
        "dining_chair": "chair",
        "dining_table": "table",
        "loveseat": "sofa",
        "nightstand": "night_stand",
        "office_chair": "chair",
        "office_desk": "desk",
        "swivel_chair": "chair",
        "writing_desk": "desk",
    }
)
"""Labels of data sets that are synonyms of a class."""
AMBIGUOUS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "armchair": ("chair", "sofa"),
        "chest_of_drawers": ("dresser", "night_stand"),
        "crib": ("bed",),
        "drawer": ("dresser", "night_stand"),
        "drawers": ("dresser", "night_stand"),
        "dresser_mirror": ("dresser",),
        "end_table": ("night_stand", "table"),
        "futon": ("bed", "sofa"),
        "ottoman": ("chair", "sofa"),
        "recliner": ("chair", "sofa"),
        "side_table": ("night_stand", "table"),
        "sofa_bed": ("bed", "sofa"),
        "sofa_chair": ("chair", "sofa"),
        "television": ("monitor",),
        "tv": ("monitor",),
        "workbench": ("desk", "table"),
    }
)
"""Labels that may mean several classes: no answer to them is clearly correct or incorrect.

Labels with a class of their own in ModelNet40 (bench, stool, wardrobe, bookshelf, tv_stand, laptop,
…) are another kind.
"""
UNLABELLED = frozenset({"unannotated", "unknown", "unlabeled", "unlabelled", "void"})
"""Labels without information about the object."""


class LabelUse(StrEnum):
    """The use of an object in an evaluation."""

    KNOWN_CLASS = "known_class"
    """An object of a class of the classifier; counts for the accuracy and for the open set."""
    OTHER_KIND = "other_kind"
    """An object of no class; counts only for the open set."""
    LEFT_OUT = "left_out"
    """An ambiguous object; counts for neither."""


@dataclass(frozen=True)
class LabelMeaning:
    """Meaning of a label to a classifier.

    Attributes:
        use: Use of the object in an evaluation.
        true_class: The class; empty unless `use` is `KNOWN_CLASS`.
    """

    use: LabelUse
    true_class: str = ""


def meaning_of(label: str, classes: Iterable[str]) -> LabelMeaning:
    """Interpret a label for a classifier.

    A label equals a class regardless of case, spaces and hyphens. `SYNONYMS` and `AMBIGUOUS` apply
    if the classifier has a class that they name; a class of the label's own name takes precedence.

    Args:
        label: Label of the data set.
        classes: Classes of the classifier.
    """
    plain = {plain_label(name): name for name in reversed(list(classes))}
    word = plain_label(label)
    for candidate in (word, SYNONYMS.get(word)):
        if candidate in plain:
            return LabelMeaning(LabelUse.KNOWN_CLASS, plain[candidate])
    if word in UNLABELLED or any(name in plain for name in AMBIGUOUS.get(word, ())):
        return LabelMeaning(LabelUse.LEFT_OUT)
    return LabelMeaning(LabelUse.OTHER_KIND)


def plain_label(label: str) -> str:
    """A label in lower case, its words joined by underscores."""
    return "_".join(label.lower().replace("-", " ").replace("_", " ").split())
