"""The answer of a classifier to one object."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.answer_text import answer_text
from circumspect.classification.confidence_rule import ConfidenceRule

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INSEPARABLE = 0.9
"""Probability of the alternatives together; the first class alone has less."""
MAX_ALTERNATIVES = 3
"""Largest number of alternatives."""
MIN_ALTERNATIVE_PROBABILITY = 0.1
"""Smallest probability of each alternative."""
UNKNOWN_OBJECT = "the object is unlike the trained classes"


def _refused(*_: Any, **__: Any) -> NoReturn:
    raise TypeError("the numbers of a prediction are read-only; write to dict(…) of them")


class ReadOnlyTable(dict[str, float]):
    """A dict that refuses to be written to and can be hashed.

    A `MappingProxyType` would do, but neither pickle nor `copy.deepcopy`, `json.dumps` or
    `dataclasses.asdict` take one.
    """

    __setitem__: Any = _refused
    __delitem__: Any = _refused
    __ior__: Any = _refused
    clear: Any = _refused
    pop: Any = _refused
    popitem: Any = _refused
    setdefault: Any = _refused
    update: Any = _refused

    def __hash__(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        return hash(frozenset(self.items()))

    def __reduce__(self) -> tuple[type[ReadOnlyTable], tuple[dict[str, float]]]:
        # A dict is unpickled item by item otherwise, which is refused.
        return ReadOnlyTable, (dict(self),)


@dataclass(frozen=True)
class Prediction:
    """The class of one object; it can be compared, hashed, copied and pickled.

    Attributes:
        label: The most probable class.
        probability: Its probability, 0 … 1.
        probabilities: Class to probability, in the classifier's order; they sum to 1.
        milliseconds: Stage to time spent [ms]; not compared: the same answer may take longer.
        in_distribution: Whether the object resembles the trained classes; where it does not, the
            label is only the nearest class.
        distance: To the nearest training object, see `NearExample`; None where the classifier's
            file does not hold them.
        coverage: Share of the azimuth from which the object was seen, 0 … 1; None where unknown.
        rule: The bounds that make an answer confident.
        in_distribution_probability: Probability of being of one of the classes; None where the
            classifier's file has no such model.
        ambiguity: Why a probable answer is not confident, as where the object may stand on another
            face; empty as a rule.
    """

    label: str
    probability: float
    probabilities: Mapping[str, float]
    milliseconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    in_distribution: bool = True
    distance: float | None = None
    coverage: float | None = None
    rule: ConfidenceRule = field(default_factory=ConfidenceRule, repr=False)
    in_distribution_probability: float | None = None
    ambiguity: str = ""

    def __post_init__(self) -> None:
        for name in ("probabilities", "milliseconds"):
            object.__setattr__(self, name, ReadOnlyTable(getattr(self, name)))

    def __repr__(self) -> str:
        state = "" if self.in_distribution else ", unknown object"
        state += ", confident" if self.confident else ""
        return f"Prediction({self.label} {self.probability:.2f}{state})"

    @property
    def text(self) -> str:
        """The answer in words, such as "bathtub (96 %)"; see `answer_parts`."""
        return answer_text(self.label, self.probability, self.in_distribution, self.alternatives)

    @property
    def confident(self) -> bool:
        """Whether the answer may be acted on: in distribution, probable, enough coverage."""
        return not self.reason

    @property
    def reason(self) -> str:
        """Why the answer is not confident; empty if it is."""
        if not self.in_distribution:
            return UNKNOWN_OBJECT
        return self.rule.reason(self.probability, self.coverage) or self.ambiguity

    @property
    def alternatives(self) -> Mapping[str, float]:
        """Classes that shape and size do not separate, such as table and desk, most likely first.

        They include the label. Empty where the label alone has `INSEPARABLE` probability, where
        more than `MAX_ALTERNATIVES` classes would be needed, or for an unknown object. Classes of
        less than `MIN_ALTERNATIVE_PROBABILITY` are left out.
        """
        ranked = sorted(self.probabilities.items(), key=lambda item: -item[1])
        held = np.cumsum([share for _, share in ranked])
        count = int(np.searchsorted(held, INSEPARABLE)) + 1
        if not self.in_distribution or not 1 < count <= MAX_ALTERNATIVES:
            return ReadOnlyTable({})
        likely = {
            name: share for name, share in ranked[:count] if share >= MIN_ALTERNATIVE_PROBABILITY
        }
        return ReadOnlyTable(likely if len(likely) > 1 else {})

    def to_dict(self) -> dict[str, Any]:
        """The answer in JSON types, as `circumspect classify --json` prints it."""
        return {
            "label": self.label,
            "confident": self.confident,
            "reason": self.reason,
            "in_distribution": bool(self.in_distribution),
            "in_distribution_probability": _number(self.in_distribution_probability),
            "distance": _number(self.distance),
            "coverage": _number(self.coverage),
            "probability": float(self.probability),
            "probabilities": {name: float(p) for name, p in self.probabilities.items()},
            "alternatives": {name: float(p) for name, p in self.alternatives.items()},
            "milliseconds": {name: round(float(ms), 3) for name, ms in self.milliseconds.items()},
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_dict` as JSON.

        Raises:
            OutputError: The file cannot be written.
        """
        from circumspect.storage import write_json

        write_json(path, self.to_dict())

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the probabilities as bars, with the bound of a confident answer.

        Args:
            axes: Where to draw; None for a new figure.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        from circumspect.classification.prediction_plot import draw_probabilities
        from circumspect.figure_canvas import axes_or_new

        axes = axes_or_new(axes)
        state = "confident" if self.confident else f"not confident: {self.reason}"
        bound = self.rule.bound(self.coverage)
        draw_probabilities(
            axes, self.probabilities, bound, f"{self.text}\n{state}".replace("_", " ")
        )
        return axes

    @classmethod
    def from_probabilities(
        cls,
        classes: Sequence[str],
        probabilities: NDArray[np.floating],
        milliseconds: Mapping[str, float] | None = None,
        **others: Any,
    ) -> Prediction:
        """Build from a vector.

        Args:
            classes: The c class names.
            probabilities: (c,) that sum to 1.
            milliseconds: Stage to time spent [ms].
            others: Further attributes.

        Raises:
            ValueError: There are not as many probabilities as classes, or none.
        """
        best = int(np.argmax(probabilities))
        named = {name: float(p) for name, p in zip(classes, probabilities, strict=True)}
        return cls(
            label=classes[best],
            probability=float(probabilities[best]),
            probabilities=named,
            milliseconds=milliseconds or {},
            **others,
        )


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)
