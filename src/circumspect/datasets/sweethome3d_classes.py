"""Classes of pieces of Sweet Home 3D catalogues, from their English name, category and size."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

from circumspect.datasets.mesh_set import AMBIGUOUS, OTHER
from circumspect.datasets.verification import MODELNET10

CLASSES = tuple(sorted(MODELNET10))
"""Names of the labels, in alphabetical order."""

NEVER_FURNITURE = ("Characters", "Doors and windows", "Staircases", "Vehicles")
"""Categories without furniture."""
SHORTEST_SIDE, LONGEST_SIDE, THINNEST_SIDE = 0.30, 3.50, 0.03
"""Furniture has its longest side between the first two values, and no side below the third [m]."""
LOWEST_CHAIR = 0.5
"""Seats below this height are stools [m]."""


@dataclass(frozen=True)
class Rule:
    """A rule of the table.

    Attributes:
        answer: A class, "other" or "ambiguous".
        words: Whole words or phrases; the name must contain one of them, with or without a plural
            s. Empty means any name.
        without: Words that the name must not contain.
        categories: Allowed categories; empty means any.
        upright: Whether the piece must be taller than wide and deep, and at least as high as a
            chair.
    """

    answer: str
    words: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    categories: tuple[str, ...] = ()
    upright: bool = False

    def fits(self, name: str, category: str, metres: tuple[float, float, float]) -> bool:
        """Whether the rule applies to a piece of this name, category, width, depth and height."""
        width, depth, height = metres
        return (
            (not self.categories or category in self.categories)
            and (not self.words or self._with.search(name) is not None)
            and (not self.without or self._without.search(name) is None)
            and (not self.upright or height >= max(width, depth, LOWEST_CHAIR))
        )

    @cached_property
    def _with(self) -> re.Pattern[str]:
        return _any_of(self.words)

    @cached_property
    def _without(self) -> re.Pattern[str]:
        return _any_of(self.without)


def _any_of(words: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile(rf"\b(?:{'|'.join(map(re.escape, words))})s?\b", re.IGNORECASE)


RULES = (
    Rule("other", categories=NEVER_FURNITURE),
    # Accessories that are named after the furniture they are used with.
    Rule("other", ("lamp", "fan", "bat", "brush", "paper", "towel", "mat", "remote control",
                   "antenna", "plug", "freezer")),
    # An office chair with arms is a chair; other armchairs are between chair and sofa.
    Rule("chair", ("armchair",), categories=("Office",), upright=True),
    # Seats that are neither chairs nor sofas.
    Rule("ambiguous", ("armchair", "stool", "bench", "ottoman", "puff", "pouf", "lounge",
                       "wheelchair", "bar chair", "high chair", "deck chair", "beach chair")),
    Rule("ambiguous", ("bank",), categories=("Exterior",)),
    # Sleeping furniture other than a bed on legs.
    Rule("ambiguous", ("baby bed", "day bed", "loft bed", "mezzanine bed", "sofa bed", "opened",
                       "crib", "cot", "mattress", "sleeping bag")),
    Rule("ambiguous", ("futon",), without=("sofa", "couch")),
    # Tables for special purposes.
    Rule("ambiguous", ("changing table", "dressing table", "football table", "pool table",
                       "table tennis", "technical table", "workbench")),
    # Storage that resembles a dresser or a night stand, or holds a screen.
    Rule("ambiguous", ("cupboard", "filing cabinet", "drawers cabinet", "tv stand", "tv unit",
                       "tv cabinet", "television cabinet", "living room")),
    Rule("ambiguous", ("box",), categories=("Living room", "Office")),
    # Flat panels that resemble a monitor.
    Rule("ambiguous", ("screen", "white board", "laptop", "notebook", "ibook")),
    # Objects that resemble a toilet or a bathtub.
    Rule("ambiguous", ("bidet", "urinal", "potty", "jacuzzi")),
    # The classes. The first one counts if a name contains two of them.
    Rule("toilet", ("toilet",)),
    Rule("bathtub", ("bath", "bathtub")),
    Rule("night_stand", ("bedside table", "nightstand", "night stand")),
    Rule("sofa", ("sofa", "couch")),
    Rule("chair", ("chair", "seat"), upright=True),
    Rule("ambiguous", ("chair", "seat")),
    Rule("bed", ("bed",)),
    Rule("dresser", ("dresser", "chest of drawers")),
    Rule("dresser", ("chest",), categories=("Bedroom",)),
    Rule("ambiguous", ("chest",)),
    Rule("monitor", ("monitor", "tv", "television", "imac")),
    Rule("desk", ("desk",)),
    Rule("table", ("table",)),
)  # fmt: skip
"""The first rule that applies decides; otherwise the label is "other"."""


def label_of(name: str, category: str, metres: tuple[float, float, float]) -> int:
    """Index into `CLASSES`, `OTHER` or `AMBIGUOUS`.

    Pieces with a name but not the size of furniture, such as a chair for dolls, are ambiguous.

    Args:
        name: Name in the catalogue, in English.
        category: Category in the catalogue, in English.
        metres: Width, depth and height [m].
    """
    answers = (rule.answer for rule in RULES if rule.fits(name, category, metres))
    answer = next(answers, "other")
    if answer == "other":
        return OTHER
    if answer == "ambiguous" or not has_furniture_size(category, metres):
        return AMBIGUOUS
    return CLASSES.index(answer)


def has_furniture_size(category: str, metres: tuple[float, float, float]) -> bool:
    """Whether a piece has the size of furniture and a category with furniture.

    Args:
        category: Category in the catalogue, in English.
        metres: Width, depth and height [m].
    """
    return (
        category not in NEVER_FURNITURE
        and SHORTEST_SIDE <= max(metres) <= LONGEST_SIDE
        and min(metres) >= THINNEST_SIDE
    )
