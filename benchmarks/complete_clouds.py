"""What the classifier says of the complete clouds of scanned objects."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from circumspect.classification import Classifier
from circumspect.datasets.point_pack import read_point_pack
from circumspect.geometry import PointCloud


def complete_answers(found: Sequence[dict[str, Any]], data: Path) -> dict[str, str]:
    """Object to label, by the points that the scanned surface was made of.

    Args:
        found: Records of scans of objects from point packs.
        data: Folder of the packs.
    """
    classifier, answers = Classifier.load(), {}
    names = {record["object"] for record in found}
    for file in sorted(data.glob("*.npz")):
        pack = read_point_pack(file)
        for index, name in enumerate(pack.names):
            if str(name) in names:
                cloud = PointCloud(pack.points_xyz[index])
                answers[str(name)] = classifier.classify(cloud).label
    return answers
