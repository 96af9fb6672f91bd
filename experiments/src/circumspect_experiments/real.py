"""Comparison of classifiers on real objects.

All contenders are trained on the same CAD data with the same simulated partial views, and on no
real object. Every answer is stored, so that results can be compared object by object.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from circumspect import __version__
from circumspect.classification.shipped import ROBOT, SHIPPED, shipped_path
from circumspect.datasets import GridCache, open_data_set
from circumspect.datasets.catalogue import read_catalogue
from circumspect.datasets.labelled_crops import (
    LabelledCrops,
    read_crop_sources,
    require_usable_labels,
)
from circumspect.errors import InputError, printable
from circumspect.evaluation.crop_answers import CropAnswer, Scale, answer_crops
from circumspect.evaluation.crop_metrics import crop_metrics
from circumspect.evaluation.predictor import Predictor, checkpoint_path, load_predictor
from circumspect.nets.registry import net_spec, net_words
from circumspect.training.train import train
from circumspect_experiments.experiment import Experiment
from circumspect_experiments.paired_comparison import compared_to_first, leave_one_room_out
from circumspect_experiments.real_report import real_markdown
from circumspect_experiments.stages import RESULT, Watched, done_once, file_digest, write_report

NAME = "real"
"""Name of the experiment and of its files."""
REPLICAS = 6
"""Number of simulated scans of each labelled training object."""
CATALOGUE_REPLICAS = 12
"""Number of simulated scans of each catalogue object; each kind of input takes minutes."""


@dataclass(frozen=True, kw_only=True)
class RealObjects(Experiment):
    """Settings of the comparison on real objects; see `Experiment`.

    Attributes:
        nets: Networks to train.
        contenders: Name to file of trained classifiers: ONNX files, checkpoints or folders of runs.
            The others are compared with the first contender.
        catalogues: Packs of meshes in metres on which `nets` are trained beside `data`.
        scale: "unknown" hides from all classifiers that coordinates are in metres.
        data: The CAD data on which `nets` are trained.
    """

    nets: tuple[str, ...] = ()
    contenders: Mapping[str, Path] = field(default_factory=lambda: {ROBOT: shipped_path(ROBOT)})
    catalogues: tuple[Path, ...] = ()
    scale: Scale = "metric"
    data: Path | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "nets", tuple(net_spec(net).name for net in self.nets))
        super().__post_init__()
        if both := set(self.nets) & set(self.contenders):
            raise InputError(f"--contenders {min(both)}=…: is the name of a network to train")
        if not self.nets and not self.contenders:
            raise InputError("there is nothing to compare; give --contenders NAME=FILE")

    @property
    def trained_nets(self) -> tuple[str, ...]:
        """See `Experiment.trained_nets`."""
        return self.nets

    def command_on(self, crops: Sequence[Path]) -> str:
        """The command that repeats the experiment, without local folders."""
        words = ["circumspect", "reproduce", NAME, "--crops", *(path.name for path in crops)]
        named = [_as_typed(name, path) for name, path in self.contenders.items() if name != ROBOT]
        words += ["--contenders", *named] if named else []
        words += ["--scale", self.scale] if self.scale != "metric" else []
        words += self._training_words() if self.nets else []
        return printable(shlex.join(words)).replace("`", "'")

    def _training_words(self) -> list[str]:
        """The flags that determine the trainings."""
        words = ["--nets", *map(net_words, self.nets)]
        words += [] if self.data is None else ["--data", self.data.name]
        packs = [path.name for path in self.catalogues]
        words += ["--catalogue", *packs] if packs else []
        return [*words, *self.training_flags()]


def _as_typed(name: str, path: Path) -> str:
    """A contender in the format of `named_contenders`."""
    shipped = next((one for one in SHIPPED if shipped_path(one) == path), None)
    return name if name == shipped else f"{name}={shipped or path.name}"


def named_contenders(words: Sequence[str]) -> dict[str, Path]:
    """The shipped classifier, and the contenders of the user.

    Args:
        words: NAME=FILE, or FILE, whose name is derived from the file. FILE may be the name of a
            shipped classifier.

    Raises:
        InputError: A name has no file, or is repeated.
    """
    found = {ROBOT: shipped_path(ROBOT)}
    for word in words:
        name, equals, file = word.partition("=")
        file = file if equals else word
        path = shipped_path(file) if file in SHIPPED else Path(file)
        name = name if equals else path.stem
        if not name or not str(path) or (equals and not file):
            raise InputError(f"--contenders {word}: give NAME=FILE")
        if name in found:
            raise InputError(f"--contenders {word}: {name} stands for another classifier already")
        found[name] = path
    return found


def trained_contender(
    net: str,
    how: RealObjects,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> Path:
    """Train a network on simulated partial views of CAD data, unless it is already trained.

    All networks use the same objects, scans and held-back part.

    Args:
        net: Name of the network in the registry.
        how: Settings; `how.data` is the CAD data.
        folder: The run goes to `NET/training`.
        watched: Receives the progress.
        cache: Cache for grids.

    Returns:
        The checkpoint.

    Raises:
        InputError: There are no CAD data, or the folder contains another training.
        OutputError: The folder can not be written.
    """
    if how.data is None:
        raise InputError(f"--nets {net}: needs --data, the CAD data to train on")
    objects = open_data_set(how.data, "train")
    settings = replace(
        how.settings(net), scans=True, replicas=REPLICAS, catalogue_replicas=CATALOGUE_REPLICAS
    )
    packs = [read_catalogue(path) for path in how.catalogues]
    at = folder / _as_folder(net) / "training"
    with watched.training(net, settings.epochs) as observer:
        train(objects, settings, at, observer, cache, catalogues=packs)
    return at


def reproduce_real(
    crops: Sequence[Path],
    how: RealObjects,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> dict[str, Any]:
    """Classify real objects with all contenders.

    Finished stages in the folder are kept.

    Args:
        crops: Files of labelled crops, see `read_labelled_crops`.
        how: Settings.
        folder: For the runs, `real.md` and `real.json`.
        watched: Receives the progress.
        cache: Cache for grids.

    Returns:
        Content of `real.json`.

    Raises:
        InputError: A file can not be read, no label can be judged, contenders have different
            classes, or the folder holds results of another experiment.
        WeightsError: A contender is missing, broken, or of another program.
        OutputError: The folder can not be written.
    """
    sources = read_crop_sources(crops)
    # Errors in files are reported before hours of training.
    contenders = [_loaded(name, path) for name, path in how.contenders.items()]
    if contenders:
        require_usable_labels(sources.values(), _common_classes(contenders))
    for net in how.nets:
        contenders.append(_loaded(net, trained_contender(net, how, folder, watched, cache)))
    classes = _common_classes(contenders)
    require_usable_labels(sources.values(), classes)
    answers = {
        contender.name: [
            answer
            for source, one in sources.items()
            for answer in contender.answers(source, one, how.scale, folder, watched)
        ]
        for contender in contenders
    }
    document = {
        "circumspect": __version__,
        "command": how.command_on(crops),
        "scale": how.scale,
        "data": {name: one.digest for name, one in sources.items()},
        "contenders": {name: crop_metrics(found, classes) for name, found in answers.items()},
        "paired": compared_to_first(answers),
        "leave_one_room_out": leave_one_room_out(answers),
    }
    write_report(document, real_markdown(document), folder, NAME)
    return document


@dataclass(frozen=True)
class CropContender:
    """A classifier in the comparison on real objects.

    Attributes:
        name: Name in tables.
        file: ONNX file or checkpoint.
        predictor: The loaded classifier.
    """

    name: str
    file: Path
    predictor: Predictor

    def answers(
        self, source: str, crops: LabelledCrops, scale: Scale, folder: Path, watched: Watched
    ) -> list[CropAnswer]:
        """The answers for the objects of a file, stored in the folder.

        Raises:
            InputError: The folder contains other or broken answers, or an object can not be
                classified.
            OutputError: It can not be written.
        """
        at = folder / _as_folder(self.name) / _as_folder(source)
        made_of = {"weights": file_digest(self.file), "data": crops.digest, "scale": scale}

        def found() -> list[dict[str, Any]]:
            with watched.measuring(f"{self.name}, {source}") as progress:
                answers = answer_crops(self.predictor, {source: crops}, scale, progress)
            return [answer.to_dict() for answer in answers]

        documents = done_once(at, made_of, found, list)
        try:
            if len(documents) != len(crops):
                raise InputError(f"holds {len(documents)} answers to {len(crops)} objects")
            # The name of a file may differ between runs; its content does not.
            return [replace(CropAnswer.from_dict(one), source=source) for one in documents]
        except InputError as error:
            raise InputError(
                f"{at / RESULT}: {error}; remove the folder {at}, and it is made again"
            ) from error


def _loaded(name: str, weights: Path) -> CropContender:
    return CropContender(name, checkpoint_path(weights), load_predictor(weights))


def _common_classes(contenders: Sequence[CropContender]) -> tuple[str, ...]:
    """The common classes of all contenders; all other labels are other kinds."""
    first, *others = contenders
    classes = first.predictor.classes
    for other in others:
        if set(other.predictor.classes) != set(classes):
            raise InputError(
                f"{other.name} knows {', '.join(other.predictor.classes)}, but {first.name} knows "
                f"{', '.join(classes)}; compare classifiers of the same classes"
            )
    return classes


def _as_folder(name: str) -> str:
    """A name without characters that have a meaning in paths."""
    plain = "".join(sign if sign.isalnum() or sign in "-_." else "-" for sign in name)
    return plain.lstrip(".") or "-"
