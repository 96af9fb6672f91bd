"""Paired comparison of several classifiers on the same objects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scipy.stats import binomtest

from circumspect.datasets.label_meaning import LabelUse
from circumspect.evaluation.crop_answers import CropAnswer
from circumspect.evaluation.crop_metrics import share, used_as

Answers = Mapping[str, Sequence[CropAnswer]]
"""Name of each classifier to its answers; all in the same order of objects."""


def compared_to_first(answers: Answers) -> dict[str, dict[str, Any]]:
    """Compare each classifier with the first one, object by object.

    Returns:
        Name of each further classifier to `gained`, the number of objects that only it classifies
        correctly; `lost`, the number that only the first one does; and `p`, the probability of at
        least this difference if both are equally good (exact sign test).
    """
    first, *others = (used_as(row, LabelUse.KNOWN_CLASS) for row in answers.values())
    found = {}
    for name, row in zip(list(answers)[1:], others, strict=True):
        pairs = [(a.correct, b.correct) for a, b in zip(first, row, strict=True)]
        lost, gained = pairs.count((True, False)), pairs.count((False, True))
        p = binomtest(gained, gained + lost).pvalue if gained + lost else 1.0
        found[name] = {"gained": gained, "lost": lost, "p": float(p)}
    return found


def leave_one_room_out(answers: Answers) -> dict[str, Any]:
    """Unbiased accuracy of choosing the best classifier on real objects.

    For each room, the classifier with the best accuracy in all other rooms is chosen, the first
    of equal ones. Its answers in that room are counted.

    Returns:
        `rooms` with the chosen classifier and the counts of each room, and `chosen`, the accuracy
        over all rooms. With a single room, `rooms` is empty.
    """
    known = {name: used_as(row, LabelUse.KNOWN_CLASS) for name, row in answers.items()}
    per_room = {name: _by_room(row) for name, row in known.items()}
    rooms = sorted(next(iter(per_room.values())))
    if len(rooms) < 2:
        rooms = []
    found = []
    for room in rooms:
        elsewhere = {
            name: sum(sum(row) for other, row in mine.items() if other != room)
            for name, mine in per_room.items()
        }
        chosen = max(elsewhere, key=lambda name: elsewhere[name])
        correct = per_room[chosen][room]
        found.append({
            "source": room[0], "scene": room[1], "chosen": chosen, "objects": len(correct),
            "correct": sum(correct),
        })  # fmt: skip
    total = share(sum(row["correct"] for row in found), sum(row["objects"] for row in found))
    return {"rooms": found, "chosen": total}


def _by_room(known: Sequence[CropAnswer]) -> dict[tuple[str, str], list[bool]]:
    """File and room to whether each object in it is classified correctly."""
    rooms: dict[tuple[str, str], list[bool]] = {}
    for answer in known:
        rooms.setdefault((answer.source, answer.scene), []).append(answer.correct)
    return rooms
