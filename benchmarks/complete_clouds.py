"""Answers of the scans' classifier to the complete clouds of the scanned objects."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from circumspect.classification import Classifier
from circumspect.classification.shipped import MODELNET10
from circumspect.datasets.point_pack import read_point_pack
from circumspect.geometry import PointCloud


def classifier_of(found: Sequence[dict[str, Any]]) -> str:
    """The classifier of the scans; older records do not name it."""
    names = {record.get("model", MODELNET10) for record in found}
    if len(names) > 1:
        raise ValueError(f"scans of several classifiers in one table: {', '.join(sorted(names))}")
    return names.pop()


def complete_answers(found: Sequence[dict[str, Any]], data: Path) -> dict[str, str]:
    """Label of each object, from the points that its scanned surface was built from.

    Args:
        found: Records of scans of objects from point packs.
        data: Folder of the packs.
    """
    classifier, answers = Classifier.load(classifier_of(found)), {}
    names = {record["object"] for record in found}
    for file in sorted(data.glob("*.npz")):
        pack = read_point_pack(file)
        for index, name in enumerate(pack.names):
            if str(name) in names:
                cloud = PointCloud(pack.points_xyz[index])
                answers[str(name)] = classifier.classify(cloud).label
    return answers
