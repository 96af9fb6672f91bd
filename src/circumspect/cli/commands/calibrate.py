"""`circumspect calibrate`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from circumspect.cli.config_file import ConfigFlag
from circumspect.cli.draft import draft_of
from circumspect.errors import InputError, MissingExtraError, printable

if TYPE_CHECKING:
    from circumspect.classification import OnnxClassifier
    from circumspect.datasets.labelled_surfaces import LabelledSurfaces
    from circumspect.datasets.scan_augmentation import ScanAugmentation

PROCEDURAL = 12
"""Number of procedural objects of each category and of each other kind that are scanned."""


@dataclass(frozen=True)
class Calibrate:
    """Fit temperature, open-set test and confidence bounds to held-back objects.

    $ circumspect calibrate robot.onnx robot.onnx --data ModelNet10
    $ circumspect calibrate robot.onnx out.onnx --data ModelNet10 --real objects.npz
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL.onnx")]
    """Classifier trained with --scans and written by `circumspect export`."""
    out: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT.onnx")]
    """File to write; it may be MODEL itself."""
    data: Path
    """Labelled set that the classifier was trained on; only its held-back objects are used."""
    catalogue: tuple[Path, ...] = ()
    """Mesh packs that it was trained on; only their held-back objects are used."""
    real: tuple[Path, ...] = ()
    """Files of labelled real objects (docs/real-objects.md). For unknown coverage, all of them
    together have the same weight as all simulated scans."""
    scans: int = 4
    """Number of simulated scans of each object."""
    max_error_rate: float = 0.02
    """Maximum fraction of confident answers that are wrong. It determines the lower bound of the
    probability for each range of coverage."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Fit, write the file and print the results."""
        from circumspect.classification import Classifier, GridSpec
        from circumspect.classification.onnx_classifier import OnnxClassifier
        from circumspect.cli.progress import progress_bar
        from circumspect.datasets.labelled_crops import read_labelled_crops
        from circumspect.evaluation.classifier_calibration import Answers, calibrate, real_answers
        from circumspect.evaluation.held_back_scans import held_back_scans

        try:
            from circumspect.export.description import write_calibrated
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        if not 0 < self.max_error_rate < 1:
            raise InputError(
                f"--max-error-rate is a share between 0 and 1, not {self.max_error_rate}"
            )
        classifier = Classifier.load(self.model)
        if classifier.taught:
            raise InputError(
                f"{self.model}: was taught classes; calibrate the classifier that was taught, and "
                "teach it again"
            )
        input_spec = classifier.input_spec
        assert isinstance(classifier, OnnxClassifier)
        if not isinstance(input_spec, GridSpec) or not input_spec.takes_context:
            raise InputError(f"{self.model}: was not trained with --scans; there is nothing to fit")
        sources = calibration_objects(classifier, self.data, self.catalogue)
        with progress_bar("simulated scans") as progress:
            augmentation = scan_augmentation(classifier)
            scans = held_back_scans(
                sources, augmentation, input_spec, self.scans, progress=progress
            )
        seen = scans.with_rays()
        real = [real_answers(classifier, read_labelled_crops(path))[0] for path in self.real]
        found = calibrate(
            classifier,
            Answers.of(classifier, seen),
            Answers.of(classifier, scans.without_rays()),
            Answers.joined(real) if real else None,
            self.max_error_rate,
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


def calibration_objects(
    classifier: OnnxClassifier, data: Path, catalogues: Sequence[Path]
) -> list[LabelledSurfaces]:
    """The held-back objects of a network, and procedural objects.

    Args:
        classifier: Its file lists the objects that it was fitted to.
        data: Labelled set that it was trained on.
        catalogues: Mesh packs that it was trained on.

    Raises:
        InputError: It was fitted to all objects of these sets.
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
    """The augmentation of the scans that a classifier was trained on.

    Raises:
        InputError: Its file does not describe it.
    """
    from circumspect.datasets.scan_augmentation import ScanAugmentation

    document = classifier.training.get("settings", {}).get("scan")
    return ScanAugmentation.from_dict(document)
