"""Several files of labelled real objects, each under a short name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from circumspect.datasets.label_meaning import LabelUse, meaning_of
from circumspect.datasets.labelled_crops import LabelledCrops, read_labelled_crops
from circumspect.errors import InputError, printable


def read_crop_sources(paths: Sequence[Path]) -> dict[str, LabelledCrops]:
    """Read files of labelled crops.

    A file is named after itself, `kitchen` for `kitchen.npz`; files of the same name after their
    folders as well.

    Args:
        paths: At least one.

    Returns:
        Name of each file to its objects, in the order given.

    Raises:
        InputError: See `read_labelled_crops`; or a file is given twice, or none is given.
    """
    if not paths:
        raise InputError("no file of labelled objects is given; name one at least")
    counts = Counter(path.resolve() for path in paths)
    if twice := [path for path in paths if counts[path.resolve()] > 1]:
        raise InputError(f"{twice[0]}: is given more than once")
    return {
        name: read_labelled_crops(path)
        for name, path in zip(_short_names(paths), paths, strict=True)
    }


def require_usable_labels(files: Iterable[LabelledCrops], classes: Sequence[str]) -> None:
    """Check that an answer to one object at least can be correct or wrong.

    Args:
        files: Of labelled crops.
        classes: Of the classifier.

    Raises:
        InputError: All labels are ambiguous or say nothing.
    """
    labels = {label for crops in files for label in crops.labels.tolist()}
    if all(meaning_of(label, classes).use is LabelUse.LEFT_OUT for label in labels):
        some = ", ".join(printable(label) for label in sorted(labels)[:3])
        raise InputError(
            f"no label of the real objects says what the answer should be ({some}); "
            "docs/real-objects.md lists ambiguous labels"
        )


def _short_names(paths: Sequence[Path]) -> list[str]:
    """The last parts of each path, as few as tell all of them apart."""
    whole = [path.resolve().with_suffix("").parts for path in paths]
    depth = 1
    while len({parts[-depth:] for parts in whole}) < len(whole) and depth < max(map(len, whole)):
        depth += 1
    names = ["/".join(parts[-depth:]) for parts in whole]
    # Files that differ by their suffix alone.
    return names if len(set(names)) == len(names) else [path.name for path in paths]
