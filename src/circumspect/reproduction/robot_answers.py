"""What the robot's own classifier answers to the grids that it made while it scanned."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from circumspect.classification import Classifier
from circumspect.classification.model_description import OBJECTS
from circumspect.gathering.object_selection import object_name
from circumspect.grid import OccupancyGrid
from circumspect.reproduction.robot_scans import RobotScans
from circumspect.reproduction.start_answers import StartAnswers


def robot_answers(
    scans: RobotScans, progress: Callable[[int, int], None] | None = None
) -> tuple[StartAnswers, int]:
    """Name the grids of all test scans; they hold free space, and their bounds are in metres.

    Args:
        scans: The set.
        progress: Called with (done, all).

    Returns:
        The answers, and the number of scans that are left out because the classifier was trained
        on their objects.

    Raises:
        InputError: A grid is missing or broken.
    """
    classifier = Classifier.load("robot")
    fitted = {object_name(name) for name in classifier.training.get(OBJECTS) or []}
    total = sum(len(test) for test in scans.tests.values())
    done = left_out = 0
    labels, answers, objects = {}, {}, {}
    for start, test in scans.tests.items():
        chosen, found = [], []
        for index, (name, shown) in enumerate(zip(test.names, test.shown, strict=True)):
            done += 1
            if shown in fitted:
                left_out += 1
                continue
            grid = OccupancyGrid.load(scans.grids[str(name)])
            label = classifier.classify_grid(grid, metric=True).label
            known = label in test.classes
            found.append(test.classes.index(label) if known else len(test.classes))
            chosen.append(index)
            if progress is not None:
                progress(done, total)
        labels[start] = test.labels[chosen]
        answers[start] = np.array(found, np.int64)
        objects[start] = test.shown[chosen]
    return StartAnswers(
        labels, answers, objects, next(iter(scans.tests.values())).classes
    ), left_out
