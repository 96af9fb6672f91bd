"""A classifier's answers to labelled real objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any, Literal

import numpy as np

from circumspect.classification import Classifier
from circumspect.classification.cloud_checks import require_plausible_size
from circumspect.classification.prediction import Prediction
from circumspect.datasets.label_meaning import LabelUse, meaning_of
from circumspect.datasets.labelled_crops import LabelledCrops
from circumspect.errors import InputError, printable
from circumspect.evaluation.predictor import Predictor
from circumspect.geometry import PointCloud, require_extent

Scale = Literal["metric", "unknown"]
"""Whether the classifier takes coordinates as metres."""


@dataclass(frozen=True)
class CropAnswer:
    """The answer to one real object, and its label.

    Attributes:
        source: Name of the file that it comes from.
        scene: The room in which it stands.
        name: Identifies the object within the file.
        label: Its label in the file.
        use: Whether that is a class of the classifier.
        true_class: The class; empty if the label is none.
        answer: The most probable class.
        probabilities: Class to probability, in the classifier's order; they sum to 1.
        confident: Whether the answer may be acted on, by the classifier's rule.
        reason: Why not; empty if it may.
        in_distribution: Whether the object resembles the trained classes.
        in_distribution_probability: Probability of belonging to one of the classes; None if the
            classifier has no such model.
        distance: To the nearest training object; None where the classifier does not hold them.
        alternatives: Classes that the classifier does not separate, with their probabilities.
    """

    source: str
    scene: str
    name: str
    label: str
    use: LabelUse
    true_class: str
    answer: str
    probabilities: Mapping[str, float]
    confident: bool
    reason: str
    in_distribution: bool
    in_distribution_probability: float | None
    distance: float | None
    alternatives: Mapping[str, float]

    @property
    def probability(self) -> float:
        """Probability of the answer."""
        return self.probabilities[self.answer]

    @property
    def second(self) -> str:
        """The second most probable class; the answer itself if it is the only class."""
        others = {name: p for name, p in self.probabilities.items() if name != self.answer}
        return max(others, key=lambda name: others[name], default=self.answer)

    @property
    def correct(self) -> bool:
        """Whether the answer equals the true class; false for objects of another kind."""
        return self.use is LabelUse.KNOWN_CLASS and self.answer == self.true_class

    @property
    def is_error(self) -> bool:
        """Whether acting on the answer would be an error.

        For known classes this is every wrong answer, for other kinds every confident one.
        """
        if self.use is LabelUse.KNOWN_CLASS:
            return not self.correct
        return self.use is LabelUse.OTHER_KIND and self.confident

    def to_dict(self) -> dict[str, Any]:
        """The answer in JSON types; `from_dict` reads it back."""
        return {**asdict(self), "use": self.use.value}

    @classmethod
    def from_dict(cls, document: Any) -> CropAnswer:
        """Read what `to_dict` returned.

        Raises:
            InputError: Not such a document.
        """
        try:
            answer = cls(**{**document, "use": LabelUse(document["use"])})
            texts = (answer.source, answer.scene, answer.name, answer.label, answer.reason)
            flags = (answer.confident, answer.in_distribution)
            scores = (answer.in_distribution_probability, answer.distance)
            numbers = [*answer.probabilities.values(), *(one for one in scores if one is not None)]
            valid = (
                all(isinstance(text, str) for text in texts)
                and all(isinstance(flag, bool) for flag in flags)
                and isinstance(answer.alternatives, dict)
                and answer.answer in answer.probabilities
                and answer.true_class in ("", *answer.probabilities)
                and all(isfinite(number) for number in numbers)
            )
        except (TypeError, ValueError, KeyError, AttributeError) as error:
            raise InputError("holds no answer to an object") from error
        if not valid:
            raise InputError("holds no answer to an object")
        return answer


def answer_crops(
    predictor: Predictor,
    sources: Mapping[str, LabelledCrops],
    scale: Scale = "metric",
    progress: Callable[[int, int], None] | None = None,
) -> list[CropAnswer]:
    """Classify all objects of some files.

    Args:
        predictor: A classifier, or a checkpoint.
        sources: Name of each file to its objects.
        scale: "unknown" makes the classifier ignore that coordinates are metres.
        progress: Called with (done, all) objects.

    Returns:
        One answer per object, in the order of the files.

    Raises:
        InputError: An object spans no shape, or has an implausible size.
    """
    total, found = sum(map(len, sources.values())), []
    for source, crops in sources.items():
        for index in range(len(crops)):
            try:
                cloud = crops.cloud(index)
                _require_usable(cloud, scale)
                prediction = classified(predictor, cloud, scale)
            except InputError as error:
                title = f"{printable(source)}: {crops.title(index)}"
                raise InputError(f"{title}: {error}") from error
            found.append(_answer(predictor.classes, source, crops, index, prediction))
            if progress:
                progress(len(found), total)
    return found


def classified(predictor: Predictor, cloud: PointCloud, scale: Scale) -> Prediction:
    """The answer to one object, by a classifier or by a checkpoint.

    A checkpoint has no open-set model and no confidence rule of its own: all objects are in
    distribution, and the default rule holds.

    Raises:
        GeometryError: The points span no shape.
        InputError: An unknown scale where one is required.
    """
    if isinstance(predictor, Classifier):
        return predictor.classify(cloud, metric=scale == "metric")
    input_spec = predictor.input_spec
    inputs = input_spec.inputs(cloud)
    context = input_spec.context(inputs[0], input_spec.bounds(cloud) if scale == "metric" else None)
    probabilities = predictor.probabilities(inputs, None if context is None else context[None])
    return Prediction.from_probabilities(predictor.classes, probabilities[0])


def _require_usable(cloud: PointCloud, scale: Scale) -> None:
    """Check that an object spans a shape and has a plausible size."""
    require_extent(cloud)
    if scale == "unknown":
        return
    try:
        require_plausible_size(cloud)
    except InputError as error:
        longest = float(np.ptp(cloud.points_xyz, axis=0).max())
        raise InputError(
            f"its longest side is {longest:.3g} m; save points in metres, or give --scale unknown"
        ) from error


def _answer(
    classes: Sequence[str], source: str, crops: LabelledCrops, index: int, prediction: Prediction
) -> CropAnswer:
    meaning = meaning_of(str(crops.labels[index]), classes)
    return CropAnswer(
        source=source,
        scene=str(crops.scenes[index]),
        name=str(crops.names[index]),
        label=str(crops.labels[index]),
        use=meaning.use,
        true_class=meaning.true_class,
        answer=prediction.label,
        probabilities={name: float(prediction.probabilities[name]) for name in classes},
        confident=prediction.confident,
        reason=prediction.reason,
        in_distribution=bool(prediction.in_distribution),
        in_distribution_probability=prediction.in_distribution_probability,
        distance=prediction.distance,
        alternatives=dict(prediction.alternatives),
    )
