"""What the label of a real object means to a classifier: one of its classes, or another kind."""

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
"""Labels of data sets that are another word for a class."""
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
"""Labels that may stand for a class or for two: no answer to them is clearly right or wrong.

What ModelNet40 gives a class of its own (bench, stool, wardrobe, bookshelf, tv_stand, laptop, …) is
another kind.
"""
UNLABELLED = frozenset({"unannotated", "unknown", "unlabeled", "unlabelled", "void"})
"""Labels that say nothing of the object."""


class LabelUse(StrEnum):
    """What an object with some label can be used for."""

    KNOWN_CLASS = "known_class"
    """It is of a class of the classifier: it counts for the accuracy and for the open set."""
    OTHER_KIND = "other_kind"
    """It is of no class: it counts for the open set alone."""
    LEFT_OUT = "left_out"
    """Nobody can say which; it counts for neither."""


@dataclass(frozen=True)
class LabelMeaning:
    """What a label means to a classifier.

    Attributes:
        use: What the object can be used for.
        true_class: The class; empty unless `use` is `KNOWN_CLASS`.
    """

    use: LabelUse
    true_class: str = ""


def meaning_of(label: str, classes: Iterable[str]) -> LabelMeaning:
    """What a label means to a classifier.

    A label equals a class regardless of case, spaces and hyphens. `SYNONYMS` and `AMBIGUOUS` apply
    where the classifier has a class that they name; a class of that name goes first.

    Args:
        label: As a data set has it.
        classes: Of the classifier.
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
