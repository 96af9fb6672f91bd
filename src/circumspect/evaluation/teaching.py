"""Teach a classifier a class from a few examples, and measure the effect on other classes.

Radius and slope of the class follow from distances between features. The radius is the distance to
the nearest example that contains 5 % of the other things (procedural ones and, if their table is
available, training objects). The slope gives the median example, measured from the others, a
probability of 0.95.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import ExampleTable, OnnxClassifier
from circumspect.classification.taught_classes import MAX_SLOPE, TaughtClass, directions
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.furniture.other_things import OTHER_THINGS, make_other_thing
from circumspect.geometry import PointCloud, TriangleMesh

MIN_EXAMPLES = 5
OTHERS_WITHIN = 0.05
"""Fraction of other things that may lie within the radius."""
TRAINED_WITHIN = 0.005
"""Fraction of training objects of the existing classes that may lie within the radius."""
TYPICAL = 0.95
"""Probability of the median example."""
SAME = 1e-6
"""Distance of features below which two examples are the same object."""
FIRST_SEED = 400_000
"""First seed of procedural objects here; those for training and calibration are larger."""
OTHER_SIZES = (0.4, 0.7, 1.1, 1.6)
"""Longest sides of other things [m]; one of each kind has each size."""
PIECES = 5
"""Pieces of furniture of each category."""
SAMPLES = 32768


@dataclass(frozen=True, eq=False)
class Example:
    """An object as the network's input.

    Attributes:
        name: For messages.
        inputs: (1, views, *input_shape).
        context: (6,), or None where the network takes none or the scale is unknown.
        sha256: Of its file.
    """

    name: str
    inputs: NDArray[Any]
    context: NDArray[np.float32] | None
    sha256: str

    @classmethod
    def of_cloud(
        cls, name: str, cloud: PointCloud, classifier: OnnxClassifier, metric: bool, sha256: str
    ) -> Example:
        """An object from its cloud.

        Args:
            name: For messages.
            cloud: Its points, z up.
            classifier: Its input specification is used.
            metric: The points are in metres.
            sha256: Of the file.

        Raises:
            GeometryError: The points span no shape.
            InputError: The network needs metres.
        """
        input_spec = classifier.input_spec
        inputs = input_spec.inputs(cloud)
        bounds = input_spec.bounds(cloud) if metric and input_spec.metric else None
        return cls(name, inputs, input_spec.context(inputs[0], bounds), sha256)

    def features(self, classifier: OnnxClassifier) -> NDArray[np.float64]:
        """(f,) features of the network's last layer."""
        contexts = None if self.context is None else self.context[None]
        return classifier.features(self.inputs, contexts)[0]


@dataclass(frozen=True)
class TeachingReport:
    """Measures of a taught class.

    Attributes:
        examples: Number of examples.
        named: Number of examples with the new name and `in_distribution`, each with a class from
            the others.
        trained: Number of training objects of the existing classes; None if their table is missing.
        trained_claimed: How many of them are within the radius and nearest to an example.
        furniture: Number of procedural pieces of existing classes.
        furniture_before: Number of pieces classified correctly before.
        furniture_after: The same with the new class.
        things: Number of procedural things of other kinds.
        things_claimed: How many of them get the new name and are `in_distribution`.
    """

    examples: int
    named: int
    trained: int | None
    trained_claimed: int
    furniture: int
    furniture_before: int
    furniture_after: int
    things: int
    things_claimed: int

    def to_dict(self) -> dict[str, Any]:
        """JSON types."""
        return asdict(self)


class Teacher:
    """Makes a class from examples and measures it.

    The classifier, and the objects of other classes, are the same for all measurements.
    """

    def __init__(
        self,
        classifier: OnnxClassifier,
        name: str,
        examples: Sequence[Example],
        table: ExampleTable | None = None,
    ) -> None:
        """Compute the features of all objects.

        Args:
            classifier: The classifier to teach; it may have taught classes already.
            name: Of the new class.
            examples: At least `MIN_EXAMPLES`, all different.
            table: Its training objects, if available.

        Raises:
            InputError: The class exists, or there are too few examples or two equal ones.
            WeightsError: The network gives no features.
        """
        _require_new(classifier, name)
        if len(examples) < MIN_EXAMPLES:
            raise InputError(
                f"{len(examples)} examples are too few; give at least {MIN_EXAMPLES} objects of "
                f"the class {name}"
            )
        self.classifier, self.name, self.examples, self.table = classifier, name, examples, table
        self.features = np.stack([one.features(classifier) for one in examples])
        _require_distinct(examples, self.features)

    def taught(self, without: int | None = None) -> TaughtClass:
        """The class, from all examples or from all but one.

        Args:
            without: Index of the example to leave out.

        Raises:
            InputError: The examples are not nearer to each other than to other objects.
        """
        kept = np.delete(self.features, [] if without is None else [without], axis=0)
        unit = directions(kept)
        between = 1.0 - unit @ unit.T
        np.fill_diagonal(between, np.inf)
        nearest = np.maximum(between.min(axis=1), SAME)
        radius = self._radius(unit, float(nearest.max()))
        nearness = float(np.log(radius / np.median(nearest)))
        if nearness <= 0:
            raise InputError(
                f"the examples of {self.name} are no more like each other than like other things "
                f"(distance {np.median(nearest):.3f}, other things {radius:.3f}); give more, or "
                "examples of one kind"
            )
        slope = float(np.clip(np.log(TYPICAL / (1.0 - TYPICAL)) / nearness, 0.5, MAX_SLOPE))
        return TaughtClass(self.name, kept.astype(np.float32), radius, slope)

    def learner(self, without: int | None = None) -> OnnxClassifier:
        """The classifier with the class; see `taught`."""
        return self.classifier.with_taught((*self.classifier.taught, self.taught(without)))

    def report(self) -> TeachingReport:
        """Measure the class by leave-one-out, and its effect on other objects.

        Raises:
            InputError: See `taught`.
        """
        learner = self.learner()
        named = sum(map(self._is_named_by_others, range(len(self.examples))))
        pieces, things = self._furniture, [one for _, one in self._things]
        return TeachingReport(
            len(self.examples),
            named,
            None if self.table is None else len(self.table),
            self._claimed_of_table(),
            len(pieces),
            sum(_answer(self.classifier, one).label == label for label, one in pieces),
            sum(_answer(learner, one).label == label for label, one in pieces),
            len(things),
            sum(self._is_named(learner, one) for one in things),
        )

    def _is_named_by_others(self, index: int) -> bool:
        """Whether an example gets the name of a class from the other examples."""
        try:
            learner = self.learner(index)
        except InputError:
            # Without this example the others form no class.
            return False
        return self._is_named(learner, self.examples[index])

    def _is_named(self, learner: OnnxClassifier, example: Example) -> bool:
        answer = _answer(learner, example)
        return answer.label == self.name and answer.in_distribution

    def _radius(self, unit: NDArray[np.float64], spread: float) -> float:
        """The distance from examples that contains few other objects.

        Args:
            unit: (n, f) directions of the examples.
            spread: The largest distance of an example from the nearest other one.
        """
        kinds: dict[str, list[float]] = {}
        features = self._thing_features
        for (kind, _), distance in zip(self._things, _nearest(features, unit), strict=True):
            kinds.setdefault(kind, []).append(float(distance))
        # A kind among the examples is the class itself under another name.
        strange = [found for found in kinds.values() if np.median(found) > spread]
        radius = float(np.quantile(np.concatenate(strange), OTHERS_WITHIN)) if strange else 2.0
        if self.table is not None:
            trained = _nearest(self.table.features, unit)
            radius = min(radius, float(np.quantile(trained, TRAINED_WITHIN)))
        return max(radius, SAME)

    def _claimed_of_table(self) -> int:
        """Number of training objects within the radius and nearest to an example."""
        if self.table is None:
            return 0
        taught, unit = self.taught(), self.table.directions.astype(np.float64)
        suspects = np.flatnonzero(taught.distances(self.table.features) < taught.radius)
        claimed = 0
        for index in suspects:
            others = np.delete(unit @ unit[index], index)
            nearest_other = np.array([1.0 - others.max()])
            distance = taught.distances(self.table.features[index : index + 1])
            claimed += int((taught.log_odds(distance, nearest_other) > 0).item())
        return claimed

    @cached_property
    def _things(self) -> list[tuple[str, Example]]:
        """Kind and object: one of each kind and size."""
        made = [
            (kind, _resized(make_other_thing(kind, FIRST_SEED + number), side))
            for kind in OTHER_THINGS
            for number, side in enumerate(OTHER_SIZES)
        ]
        return [(kind, self._shown(kind, mesh)) for kind, mesh in made]

    @cached_property
    def _thing_features(self) -> NDArray[np.float64]:
        return np.stack([one.features(self.classifier) for _, one in self._things])

    @cached_property
    def _furniture(self) -> list[tuple[str, Example]]:
        """Label and object, of the classes that the classifier names."""
        return [
            (kind, self._shown(kind, make_furniture(kind, FIRST_SEED + number)))
            for kind in CATEGORIES
            if kind in self.classifier.classes
            for number in range(PIECES)
        ]

    def _shown(self, name: str, mesh: TriangleMesh) -> Example:
        return Example.of_cloud(name, mesh.sampled(SAMPLES, 0), self.classifier, True, "")


def _answer(classifier: OnnxClassifier, example: Example) -> Any:
    return classifier.classify_inputs(example.inputs, example.context)


def _nearest(features: NDArray[np.floating], unit: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) distances of features to the nearest of some directions."""
    return 1.0 - (directions(features) @ unit.T).max(axis=1)


def _resized(mesh: TriangleMesh, side: float) -> TriangleMesh:
    """The mesh scaled to a longest side [m]."""
    scale = side / float(np.ptp(mesh.vertices_xyz, axis=0).max())
    return TriangleMesh(mesh.vertices_xyz * scale, mesh.faces)


def _require_new(classifier: OnnxClassifier, name: str) -> None:
    existing = [*classifier.classes, *([classifier.other] if classifier.other else [])]
    same = [other for other in existing if other.casefold() == name.casefold()]
    if same:
        raise InputError(
            f"the classifier names {same[0]} already; known: {', '.join(classifier.classes)}"
        )


def _require_distinct(examples: Sequence[Example], features: NDArray[np.float64]) -> None:
    first: dict[str, int] = {}
    for index, example in enumerate(examples):
        if (other := first.setdefault(example.sha256, index)) != index:
            raise InputError(
                f"{example.name}: the same content as {examples[other].name}; leave one of them out"
            )
    unit = directions(features)
    between = np.tril(unit @ unit.T, -1)
    if len(examples) > 1 and between.max() > 1.0 - SAME:
        one, other = np.unravel_index(int(between.argmax()), between.shape)
        raise InputError(
            f"{examples[int(one)].name}: the same object as {examples[int(other)].name}; leave "
            "one of them out"
        )
