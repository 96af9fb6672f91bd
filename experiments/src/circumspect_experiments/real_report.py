"""Markdown report of the comparison on real objects."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from circumspect.evaluation.crop_report import (
    INTERVALS,
    WIDTH,
    command_block,
    described_table,
    percent,
    percent_interval,
    shortened,
    wrapped,
)
from circumspect.evaluation.markdown import aligned_table

NAME_WIDTH = 16
"""Maximum length of a classifier's name [characters]."""


def real_markdown(document: Mapping[str, Any]) -> str:
    """The report in Markdown.

    Args:
        document: Content of `real.json`.
    """
    first = next(iter(document["contenders"]))
    counts = document["contenders"][first]["objects"]
    scale = "in metres" if document["scale"] == "metric" else "of unknown scale"
    text = (
        f"{counts['known_classes']} objects of known classes and {counts['other_kinds']} of other "
        f"kinds, cut out of real scenes, {scale}; {counts['left_out']} with ambiguous labels are "
        f"left out. {INTERVALS}"
    )
    parts = [
        f"# Classifiers on real objects\n\n{command_block(document['command'])}\n\n{wrapped(text)}",
        _accuracy(document),
        _sources(document),
        *([_paired(document)] if document["paired"] else []),
        _confidence(document),
        _open_set(document),
        _choice(document),
    ]
    return "\n\n".join(parts) + "\n"


def _accuracy(document: Mapping[str, Any]) -> str:
    head = ["classifier", "correct", "accuracy", "95 %", "per class", "top 2"]
    rows = []
    for name, found in document["contenders"].items():
        overall, accuracy = found["overall"], found["overall"]["accuracy"]
        rows.append([
            shortened(name, NAME_WIDTH), str(accuracy["hits"]), percent(accuracy["share"]),
            percent_interval(accuracy["interval"]), percent(overall["mean_class_accuracy"]),
            percent(overall["top_2"]["share"]),
        ])  # fmt: skip
    text = (
        "Accuracy over all objects of known classes, mean accuracy per class, and how often the "
        "class is among the best two:"
    )
    return described_table(text, head, rows)


def _paired(document: Mapping[str, Any]) -> str:
    first = shortened(next(iter(document["contenders"])), NAME_WIDTH)
    rows = [
        [shortened(name, NAME_WIDTH), str(row["gained"]), str(row["lost"]), f"{row['p']:.2f}"]
        for name, row in document["paired"].items()
    ]
    text = (
        f"Beside {first}, object by object: gained are those that {first} alone names wrongly, "
        f"lost those that {first} alone names correctly. p is the probability of a difference as "
        "large as this if both were equally good (sign test)."
    )
    return described_table(text, ["classifier", "gained", "lost", "p"], rows)


def _sources(document: Mapping[str, Any]) -> str:
    sources = list(next(iter(document["contenders"].values()))["per_source"])
    room = (WIDTH - NAME_WIDTH - 4) // max(1, len(sources)) - 3
    head = ["classifier", *(shortened(name, max(room, 8)) for name in sources)]
    rows = [
        [
            shortened(name, NAME_WIDTH),
            *(
                f"{percent(row['share'])} of {row['objects']}"
                for row in found["per_source"].values()
            ),
        ]
        for name, found in document["contenders"].items()
    ]
    return f"Accuracy by file:\n\n{aligned_table(head, rows)}"


def _confidence(document: Mapping[str, Any]) -> str:
    head = ["classifier", "confident", "correct", "accuracy", "95 %", "other kinds"]
    rows = []
    for name, found in document["contenders"].items():
        known, other = found["confident"]["known_classes"], found["confident"]["other_kinds"]
        rows.append([
            shortened(name, NAME_WIDTH), percent(known["confident"]["share"]),
            str(known["correct"]["hits"]), percent(known["correct"]["share"]),
            percent_interval(known["correct"]["interval"]),
            f"{other['confident']['hits']} of {other['confident']['objects']}",
        ])  # fmt: skip
    text = (
        "Share of confident answers to objects of known classes, by the rule of each classifier "
        "with unknown coverage, and their accuracy; confident answers to objects of other kinds, "
        "which are all wrong."
    )
    return described_table(text, head, rows)


def _open_set(document: Mapping[str, Any]) -> str:
    head = ["classifier", "AUROC", "known accepted", "others accepted", "score"]
    scores = {"in_distribution_probability": "probability", "distance": "distance", "": "–"}
    rows = []
    for name, found in document["contenders"].items():
        held = found["open_set"]
        area = "–" if held["auroc"] is None else f"{held['auroc']:.2f}"
        rows.append([
            shortened(name, NAME_WIDTH), area, percent(held["known_in_distribution"]["share"]),
            percent(held["other_in_distribution"]["share"]), scores[held["measure"]],
        ])  # fmt: skip
    text = (
        "Open set: area under the ROC curve between known classes and other kinds, and the shares "
        "of both that are accepted as in distribution."
    )
    return described_table(text, head, rows)


def _choice(document: Mapping[str, Any]) -> str:
    found = document["leave_one_room_out"]
    if not found["rooms"] or len(document["contenders"]) < 2:
        return "Choosing by leave-one-room-out needs two classifiers and two rooms."
    counts = Counter(row["chosen"] for row in found["rooms"])
    chosen = ", ".join(
        f"{shortened(name, NAME_WIDTH)} in {count}" for name, count in counts.most_common()
    )
    total = found["chosen"]
    return wrapped(
        "Choosing by leave-one-room-out: for each room the classifier that is best in all other "
        f"rooms answers. Its accuracy is {percent(total['share'])} ({total['hits']} of "
        f"{total['objects']}, {percent_interval(total['interval'])}). Chosen: {chosen} of "
        f"{len(found['rooms'])} rooms."
    )
