"""`circumspect calibrate`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from circumspect.cli.draft import draft_of
from circumspect.errors import InputError, MissingExtraError, printable

if TYPE_CHECKING:
    from circumspect.classification import OnnxClassifier
    from circumspect.datasets.scan_augmentation import ScanAugmentation
    from circumspect.datasets.training_objects import TrainingObjects
    from circumspect.evaluation.classifier_calibration import Answers

PROCEDURAL = 12
"""Pieces of each category, and things of each other kind, that are scanned to calibrate by."""


@dataclass(frozen=True)
class Calibrate:
    """Fit temperature, open set and confidence to objects that were held back.

    $ circumspect calibrate robot.onnx robot.onnx --data ModelNet10
    $ circumspect calibrate robot.onnx out.onnx --data ModelNet10 --real objects.npz
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL.onnx")]
    """A classifier that `circumspect export` wrote, trained with --scans."""
    out: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT.onnx")]
    """The file to write; it may be MODEL itself."""
    data: Path
    """The labelled set that it was trained on; the objects that were held back are used."""
    catalogue: tuple[Path, ...] = ()
    """The packs of meshes that it was trained on; likewise."""
    real: tuple[Path, ...] = ()
    """Labelled real objects, see docs/real-objects.md."""
    scans: int = 4
    """Simulated scans of each object."""
    most_wrong: float = 0.02
    """Share of the confident answers that may be wrong; the bound on the probability follows from
    it, for each range of coverage."""

    def run(self) -> int:
        """Fit, write, and say what was found."""
        from circumspect.classification import Classifier, GridRecipe
        from circumspect.classification.onnx_classifier import OnnxClassifier
        from circumspect.cli.progress import progress_bar
        from circumspect.evaluation.classifier_calibration import Answers, calibrate
        from circumspect.evaluation.held_back_scans import held_back_scans

        try:
            from circumspect.export.description import write_calibrated
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        if not 0 < self.most_wrong < 1:
            raise InputError(f"--most-wrong is a share between 0 and 1, not {self.most_wrong}")
        classifier = Classifier.load(self.model)
        recipe = classifier.recipe
        assert isinstance(classifier, OnnxClassifier)
        if not isinstance(recipe, GridRecipe) or not recipe.takes_context:
            raise InputError(f"{self.model}: was not trained with --scans; there is nothing to fit")
        sources = self._held_back(classifier)
        with progress_bar("simulated scans") as progress:
            augmentation = scan_augmentation(classifier)
            scans = held_back_scans(sources, augmentation, recipe, self.scans, progress=progress)
        seen = scans.with_rays()
        files = [Answers.of(classifier, scans.without_rays())]
        files += [real_answers(classifier, path) for path in self.real]
        found = calibrate(
            classifier, Answers.of(classifier, seen), Answers.joined(files), self.most_wrong
        )
        with draft_of(self.out) as draft:
            write_calibrated(self.model, draft, found.to_dict())
        rule = found.confidence
        print(f"{printable(str(self.out))}: temperature {found.temperature:.3f}")  # noqa: T201
        for coverage, bound in zip(rule.coverage, rule.probability, strict=True):
            shown = "never" if bound > 1 else f"{bound:.1%}"
            print(f"  confident from {coverage:4.0%} coverage on: {shown}")  # noqa: T201
        shown = "never" if rule.without_coverage > 1 else f"{rule.without_coverage:.1%}"
        print(f"  confident with unknown coverage: {shown}")  # noqa: T201
        return 0

    def _held_back(self, classifier: OnnxClassifier) -> list[TrainingObjects]:
        """What the network was not fitted to."""
        import numpy as np

        from circumspect.classification.onnx_classifier import OBJECTS
        from circumspect.cli.progress import progress_bar
        from circumspect.datasets import open_data_set
        from circumspect.datasets.catalogue import read_catalogue
        from circumspect.datasets.scan_sources import of_point_set, procedural

        with progress_bar("sampling meshes") as progress:
            objects = open_data_set(self.data, "train", progress)
        fitted = set(classifier.training.get(OBJECTS, ()))
        sources = [of_point_set(objects), *map(read_catalogue, self.catalogue)]
        found = []
        for source in sources:
            held_back = np.array([name not in fitted for name in source.names.tolist()], bool)
            if held_back.any():
                found.append(source.subset(held_back))
        if not found:
            raise InputError(
                f"{self.model}: was fitted to all of these objects; calibrate a network that was "
                "trained with validation"
            )
        return [*found, procedural(PROCEDURAL, PROCEDURAL, held_back=True)]


def scan_augmentation(classifier: OnnxClassifier) -> ScanAugmentation:
    """How the scans were made that a classifier was trained on.

    Raises:
        InputError: Its file does not say.
    """
    from circumspect.datasets.scan_augmentation import ScanAugmentation

    document = classifier.training.get("settings", {}).get("scan")
    return ScanAugmentation.from_dict(document)


def real_answers(classifier: OnnxClassifier, path: Path) -> Answers:
    """What a classifier says of labelled real objects; ambiguous labels are left out."""
    import numpy as np

    from circumspect.classification import GridRecipe
    from circumspect.datasets.label_meaning import LabelUse, meaning_of
    from circumspect.datasets.labelled_crops import read_labelled_crops
    from circumspect.datasets.training_objects import OTHER
    from circumspect.evaluation.classifier_calibration import Answers
    from circumspect.evaluation.held_back_scans import HeldBackScans

    crops, recipe = read_labelled_crops(path), classifier.recipe
    assert isinstance(recipe, GridRecipe)
    inputs, contexts, labels = [], [], []
    for index, label in enumerate(crops.labels.tolist()):
        meaning = meaning_of(label, classifier.classes)
        if meaning.use is LabelUse.LEFT_OUT:
            continue
        cloud = crops.cloud(index)
        inputs.append(recipe.inputs(cloud)[0])
        contexts.append(recipe.context(inputs[-1], recipe.bounds(cloud)))
        labels.append(meaning.true_class or OTHER)
    unknown = np.full(len(labels), np.nan)
    return Answers.of(
        classifier,
        HeldBackScans(np.stack(inputs), np.array(contexts), np.array(labels), unknown),
    )
