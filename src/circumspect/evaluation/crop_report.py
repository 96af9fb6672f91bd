"""The evaluation on real objects as Markdown that can also be read as plain text.

Tables fit 80 columns; percentages are whole, as the counts are small.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from circumspect.datasets.label_meaning import AMBIGUOUS, plain_label
from circumspect.errors import printable
from circumspect.evaluation.markdown import aligned_table

WIDTH = 80
"""Columns of the report."""
MIN_LABEL_WIDTH = 12
"""Characters of a label in a confusion table; with less space confusions are listed."""
MAX_LISTED = 20
"""Confusions in a list."""
NAME_WIDTH = 20
"""Characters of a room, a file or a label in a table."""
MEASURES = {
    "in_distribution_probability": "the probability of being of one of the classes",
    "distance": "the distance to the nearest training object",
}
INTERVALS = (
    "Intervals are 95 % (Wilson). Counts are small. Views of one object are not independent, so "
    "that the true intervals are wider."
)


def report_of(metrics: Mapping[str, Any], pictures: Sequence[str] = ()) -> str:
    """The report.

    Args:
        metrics: From `crop_metrics`, with `command`.
        pictures: Names of picture files beside the report.
    """
    parts = [
        f"# Real objects\n\n{command_block(metrics['command'])}",
        _counts(metrics),
        f"## Accuracy\n\n{wrapped(INTERVALS)}\n\n{_accuracy(metrics)}",
        f"## By room\n\n{_rooms(metrics)}",
        f"## By class\n\n{_classes(metrics)}",
        f"## Answers\n\n{_confusion(metrics)}",
        f"## Confidence\n\n{_confidence(metrics)}",
        f"## Probability\n\n{_bins(metrics)}",
        f"## Open set\n\n{_open_set(metrics)}",
    ]
    if pictures:
        parts.append("\n".join(f"![{name.removesuffix('.png')}]({name})" for name in pictures))
    return "\n\n".join(parts) + "\n"


def percent(value: float | None) -> str:
    """A fraction in whole percent; a dash for None."""
    return "–" if value is None else f"{100 * value:.0f} %"


def percent_interval(interval: Sequence[float] | None) -> str:
    """An interval in whole percent; a dash for None."""
    return "–" if interval is None else f"{100 * interval[0]:.0f}–{100 * interval[1]:.0f} %"


def shortened(text: str, width: int = NAME_WIDTH) -> str:
    """A printable name that fits a column; the middle of a longer one is left out."""
    plain = printable(text).replace("|", "/").replace("`", "'")
    if len(plain) <= width:
        return plain
    return f"{plain[: (width - 1) // 2]}…{plain[len(plain) - width // 2 :]}"


def wrapped(text: str) -> str:
    """A paragraph in lines of at most 80 columns."""
    return textwrap.fill(text, WIDTH, break_long_words=False, break_on_hyphens=False)


def described_table(text: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A wrapped paragraph, and the table that it describes.

    Args:
        text: The paragraph.
        head: Names of the columns.
        rows: As many cells each.
    """
    return f"{wrapped(text)}\n\n{aligned_table(head, rows)}"


def command_block(command: str) -> str:
    """A command to copy; its lines are continued at the width of the terminal."""
    lines = textwrap.wrap(command, WIDTH - 2, break_long_words=False, break_on_hyphens=False,
                          subsequent_indent="  ")  # fmt: skip
    return "```sh\n" + " \\\n".join(lines) + "\n```"


def _share_cells(row: Mapping[str, Any]) -> list[str]:
    """Objects, hits, share and interval."""
    return [
        str(row["objects"]), str(row["hits"]), percent(row["share"]),
        percent_interval(row["interval"]),
    ]  # fmt: skip


def _counts(metrics: Mapping[str, Any]) -> str:
    counts = metrics["objects"]
    lines = [
        f"{counts['all']} objects: {counts['known_classes']} of known classes, "
        f"{counts['other_kinds']} of other kinds, {counts['left_out']} left out."
    ]
    labels = metrics["labels"]
    if others := labels["other_kind"]:
        lines.append(f"Other kinds: {_listed(others)}.")
    if ambiguous := labels["left_out"]:
        names = _listed(ambiguous, why=True)
        lines.append(f"Left out, because the label fits no single class: {names}.")
    return "\n\n".join(map(wrapped, lines))


def _listed(labels: Mapping[str, int], why: bool = False) -> str:
    """Labels with their counts, and the classes that they may stand for."""
    words = []
    for label, count in labels.items():
        meant = AMBIGUOUS.get(plain_label(label), ()) if why else ()
        reason = f", {' or '.join(meant)}" if len(meant) > 1 else ""
        words.append(f"{shortened(label)} ({count}{reason})")
    return ", ".join(words)


def _accuracy(metrics: Mapping[str, Any]) -> str:
    head = ["known classes", "all", "correct", "accuracy", "95 %"]
    overall = metrics["overall"]
    rows = [["all objects", *_share_cells(overall["accuracy"])]]
    if len(metrics["per_source"]) > 1:
        rows += [
            [shortened(name), *_share_cells(row)] for name, row in metrics["per_source"].items()
        ]
    rows.append(["class among best 2", *_share_cells(overall["top_2"])])
    mean = percent(overall["mean_class_accuracy"])
    return f"{aligned_table(head, rows)}\n\nMean accuracy per class: {mean}."


def _rooms(metrics: Mapping[str, Any]) -> str:
    several = len(metrics["per_source"]) > 1
    head = ["room", *(["file"] if several else []), "all", "correct", "accuracy", "95 %"]
    rows = [
        [
            shortened(row["scene"]) or "–",
            *([shortened(row["source"], 14)] if several else []),
            *_share_cells(row),
        ]
        for row in metrics["per_scene"]
    ]
    return aligned_table(head, rows)


def _classes(metrics: Mapping[str, Any]) -> str:
    head = ["class", "all", "correct", "accuracy", "95 %"]
    rows = [[shortened(name), *_share_cells(row)] for name, row in metrics["per_class"].items()]
    return aligned_table(head, rows)


def _confusion(metrics: Mapping[str, Any]) -> str:
    """The answers to each label."""
    classes, rows = metrics["classes"], list(_answers_by_label(metrics))
    largest = max((count for _, _, counts in rows for count in counts.values()), default=0)
    cell = max(2, len(str(largest)), len(str(len(classes))))
    width = min(WIDTH - 4 - len(classes) * (cell + 3), NAME_WIDTH + 2)
    if width < MIN_LABEL_WIDTH:
        return _confusion_list(rows)
    table = [
        [
            shortened(f"{number}{label}", width),
            *(str(counts[name]) if counts.get(name) else "." for name in classes),
        ]
        for number, label, counts in rows
    ]
    key = ", ".join(f"{number} {shortened(name)}" for number, name in enumerate(classes, start=1))
    head = ["label", *(str(number) for number in range(1, len(classes) + 1))]
    text = f"Rows are labels, columns answers: {key}."
    return described_table(text, head, table)


def _answers_by_label(metrics: Mapping[str, Any]) -> Sequence[tuple[str, str, dict[str, int]]]:
    """Number and name of each class that occurs, then other kinds, with counts by answer."""
    classes = metrics["classes"]
    known = [
        (f"{number} ", name, dict(zip(classes, counts, strict=True)))
        for number, (name, counts) in enumerate(
            zip(classes, metrics["confusion"], strict=True), start=1
        )
        if any(counts)
    ]
    others = metrics["other_kind_answers"].items()
    return [*known, *(("other: ", label, counts) for label, counts in others)]


def _confusion_list(rows: Sequence[tuple[str, str, dict[str, int]]]) -> str:
    """The most frequent wrong answers, where there are too many classes for a table."""
    wrong = [
        (count, label, answer)
        for number, label, counts in rows
        for answer, count in counts.items()
        if count and (answer != label or number == "other: ")
    ]
    wrong.sort(key=lambda row: (-row[0], row[1:]))
    head = ["label", "answer", "objects"]
    cells = [
        [shortened(label), shortened(answer), str(count)]
        for count, label, answer in wrong[:MAX_LISTED]
    ]
    more = len(wrong) - len(cells)
    note = f"\n\n{more} rarer ones are in metrics.json." if more else ""
    return f"The most frequent wrong answers.\n\n{aligned_table(head, cells)}{note}"


def _confidence(metrics: Mapping[str, Any]) -> str:
    head = ["objects", "all", "confident", "share", "correct", "accuracy", "95 %"]
    rows = []
    for name, row in metrics["confident"].items():
        confident, correct = row["confident"], row["correct"]
        rows.append([
            name.replace("_", " "), str(confident["objects"]), str(confident["hits"]),
            percent(confident["share"]), str(correct["hits"]), percent(correct["share"]),
            percent_interval(correct["interval"]),
        ])  # fmt: skip
    text = (
        "An answer is confident by the rule of the classifier, with unknown coverage. Accuracy is "
        "that of the confident answers; to an object of another kind any class is wrong."
    )
    return described_table(text, head, rows)


def _bins(metrics: Mapping[str, Any]) -> str:
    head = ["probability", "mean", "all", "correct", "accuracy", "95 %"]
    rows = [
        [
            f"{percent(row['above'])} to {percent(row['up_to'])}",
            percent(row["mean_probability"]),
            *_share_cells(row),
        ]
        for row in metrics["probability_bins"]
    ]
    error = percent(metrics["expected_calibration_error"])
    return f"{aligned_table(head, rows)}\n\nExpected calibration error: {error}."


def _open_set(metrics: Mapping[str, Any]) -> str:
    found = metrics["open_set"]
    if found["auroc"] is None:
        text = f"No area under the ROC curve: {found['reason']}."
    else:
        text = (
            f"Area under the ROC curve {found['auroc']:.2f}, by {MEASURES[found['measure']]}: the "
            "chance that an object of a known class looks more familiar than one of another kind."
        )
    head = ["objects", "all", "in distribution", "share", "95 %"]
    rows = [
        ["known classes", *_share_cells(found["known_in_distribution"])],
        ["other kinds", *_share_cells(found["other_in_distribution"])],
    ]
    return described_table(text, head, rows)
