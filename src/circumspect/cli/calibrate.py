"""`circumspect calibrate`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from circumspect.cli.draft import draft_of
from circumspect.errors import InputError, MissingExtraError, printable

if TYPE_CHECKING:
    from circumspect.classification import OnnxClassifier
    from circumspect.datasets.labelled_surfaces import LabelledSurfaces
    from circumspect.datasets.scan_augmentation import ScanAugmentation

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
    """Labelled real objects, see docs/real-objects.md. Where coverage is unknown, all of them
    together count as much as all simulated scans."""
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
        from circumspect.datasets.labelled_crops import read_labelled_crops
        from circumspect.evaluation.classifier_calibration import Answers, calibrate
        from circumspect.evaluation.held_back_scans import held_back_scans
        from circumspect.evaluation.real_answers import real_answers

        try:
            from circumspect.export.description import write_calibrated
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        if not 0 < self.most_wrong < 1:
            raise InputError(f"--most-wrong is a share between 0 and 1, not {self.most_wrong}")
        classifier = Classifier.load(self.model)
        if classifier.taught:
            raise InputError(
                f"{self.model}: was taught classes; calibrate the classifier that was taught, and "
                "teach it again"
            )
        recipe = classifier.recipe
        assert isinstance(classifier, OnnxClassifier)
        if not isinstance(recipe, GridRecipe) or not recipe.takes_context:
            raise InputError(f"{self.model}: was not trained with --scans; there is nothing to fit")
        sources = held_back_objects(classifier, self.data, self.catalogue)
        with progress_bar("simulated scans") as progress:
            augmentation = scan_augmentation(classifier)
            scans = held_back_scans(sources, augmentation, recipe, self.scans, progress=progress)
        seen = scans.with_rays()
        real = [real_answers(classifier, read_labelled_crops(path))[0] for path in self.real]
        found = calibrate(
            classifier,
            Answers.of(classifier, seen),
            Answers.of(classifier, scans.without_rays()),
            Answers.joined(real) if real else None,
            self.most_wrong,
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


def held_back_objects(
    classifier: OnnxClassifier, data: Path, catalogues: Sequence[Path]
) -> list[LabelledSurfaces]:
    """What a network was not fitted to, and procedural objects.

    Args:
        classifier: Its file names what it was fitted to.
        data: The labelled set that it was trained on.
        catalogues: The packs of meshes that it was trained on.

    Raises:
        InputError: It was fitted to all of them.
    """
    import numpy as np

    from circumspect.classification.model_description import OBJECTS
    from circumspect.cli.progress import progress_bar
    from circumspect.datasets import open_data_set
    from circumspect.datasets.catalogue import read_catalogue
    from circumspect.datasets.scan_sources import of_point_set, procedural

    with progress_bar("sampling meshes") as progress:
        objects = open_data_set(data, "train", progress)
    fitted = set(classifier.training.get(OBJECTS, ()))
    found = []
    for source in (of_point_set(objects), *map(read_catalogue, catalogues)):
        held_back = np.array([name not in fitted for name in source.names.tolist()], bool)
        if held_back.any():
            found.append(source.subset(held_back))
    if not found:
        raise InputError(
            "the classifier was fitted to all of these objects; calibrate a network that was "
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
