"""What a classifier says of labelled real objects."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridRecipe, OnnxClassifier
from circumspect.datasets.crop_sources import require_usable_labels
from circumspect.datasets.label_meaning import LabelUse, meaning_of
from circumspect.datasets.labelled_crops import LabelledCrops
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.evaluation.classifier_calibration import Answers
from circumspect.evaluation.held_back_scans import HeldBackScans


def real_answers(
    classifier: OnnxClassifier, crops: LabelledCrops
) -> tuple[Answers, NDArray[np.int64]]:
    """Ask a classifier about real objects in metres, without coverage.

    Args:
        classifier: One that takes a context.
        crops: The objects.

    Returns:
        The answers, labelled with a class or "other", and the numbers of the objects. Objects with
        an ambiguous label are left out.

    Raises:
        InputError: See `require_usable_labels`.
    """
    require_usable_labels([crops], classifier.classes)
    recipe = classifier.recipe
    assert isinstance(recipe, GridRecipe)
    inputs, contexts, labels, chosen = [], [], [], []
    for index, label in enumerate(crops.labels.tolist()):
        meaning = meaning_of(label, classifier.classes)
        if meaning.use is LabelUse.LEFT_OUT:
            continue
        cloud = crops.cloud(index)
        inputs.append(recipe.inputs(cloud)[0])
        contexts.append(recipe.context(inputs[-1], recipe.bounds(cloud)))
        labels.append(meaning.true_class or OTHER)
        chosen.append(index)
    unknown = np.full(len(labels), np.nan)
    scans = HeldBackScans(np.stack(inputs), np.array(contexts), np.array(labels), unknown)
    return Answers.of(classifier, scans), np.array(chosen)
