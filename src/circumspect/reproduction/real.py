"""Classifiers on real objects, beside each other.

All contenders are trained on the same CAD data with the same simulated partial views; none has seen
a real object. Every answer is kept, so that measures can be compared object by object.
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
from circumspect.datasets.crop_sources import read_crop_sources, require_usable_labels
from circumspect.datasets.labelled_crops import LabelledCrops
from circumspect.errors import InputError, printable
from circumspect.evaluation.crop_answers import CropAnswer, Scale, answer_crops
from circumspect.evaluation.crop_metrics import crop_metrics
from circumspect.evaluation.predictor import Predictor, checkpoint_path, load_predictor
from circumspect.nets.registry import net_spec, net_words
from circumspect.reproduction.experiment import Experiment
from circumspect.reproduction.paired_comparison import compared_to_first, leave_one_room_out
from circumspect.reproduction.real_report import real_markdown
from circumspect.reproduction.stages import RESULT, done_once, file_digest, write_report
from circumspect.reproduction.watched import Watched
from circumspect.training import train

NAME = "real"
"""Of the experiment and of its files."""
REPLICAS = 6
"""Simulated scans of each labelled object that networks are trained on …"""
CATALOGUE_REPLICAS = 12
"""… and of each object of a catalogue; every kind of input takes minutes to make."""


@dataclass(frozen=True, kw_only=True)
class RealObjects(Experiment):
    """How classifiers are compared on real objects; see `Experiment`.

    Attributes:
        nets: Networks to train.
        contenders: Name to file of classifiers that are trained already, ONNX files, checkpoints or
            folders of runs. The first contender of all is the one that others are compared with.
        catalogues: Packs of meshes in metres that `nets` are trained on beside `data`.
        scale: "unknown" withholds from all of them that coordinates are metres.
        data: The CAD data that `nets` are trained on.
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
        """What does the same again, without folders of this machine."""
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
    """A contender as `named_contenders` reads it."""
    shipped = next((one for one in SHIPPED if shipped_path(one) == path), None)
    return name if name == shipped else f"{name}={shipped or path.name}"


def named_contenders(words: Sequence[str]) -> dict[str, Path]:
    """The shipped classifier, and those that a user names.

    Args:
        words: NAME=FILE, or FILE, which is then named after itself; a shipped classifier's name
            stands for its file.

    Raises:
        InputError: A name without a file, or one that stands twice.
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
    """Train a network on simulated partial views of CAD data, or find it trained.

    All networks see the same objects, the same scans and the same held-back part.

    Args:
        net: Its name in the registry.
        how: Settings; `how.data` is the CAD data.
        folder: The run goes to `NET/training`.
        watched: Told of the progress.
        cache: Where grids are kept.

    Returns:
        The checkpoint.

    Raises:
        InputError: No CAD data are given, or the folder holds another training.
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
    """Show real objects to all contenders.

    Every stage whose result is in the folder is left as it is.

    Args:
        crops: Files of labelled crops, see `read_labelled_crops`.
        how: Settings.
        folder: For the runs, `real.md` and `real.json`.
        watched: Told of the progress.
        cache: Where grids are kept.

    Returns:
        What `real.json` holds.

    Raises:
        InputError: A file can not be read, no label can be judged, contenders know different
            classes, or the folder holds results of another experiment.
        WeightsError: A contender is missing, broken, or of another program.
        OutputError: The folder can not be written.
    """
    sources = read_crop_sources(crops)
    # What is wrong with files is found before hours of training.
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
class Contender:
    """A classifier that is compared.

    Attributes:
        name: In tables.
        file: ONNX file or checkpoint.
        predictor: What was loaded from it.
    """

    name: str
    file: Path
    predictor: Predictor

    def answers(
        self, source: str, crops: LabelledCrops, scale: Scale, folder: Path, watched: Watched
    ) -> list[CropAnswer]:
        """The answers to the objects of a file, found once.

        Raises:
            InputError: The folder holds other answers or broken ones, or an object can not be
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
            # What a file is called may differ from run to run, its content does not.
            return [replace(CropAnswer.from_dict(one), source=source) for one in documents]
        except InputError as error:
            raise InputError(
                f"{at / RESULT}: {error}; remove the folder {at}, and it is made again"
            ) from error


def _loaded(name: str, weights: Path) -> Contender:
    return Contender(name, checkpoint_path(weights), load_predictor(weights))


def _common_classes(contenders: Sequence[Contender]) -> tuple[str, ...]:
    """The classes of all contenders: what is of another kind depends on them."""
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
    """A name without what means something in a path."""
    plain = "".join(sign if sign.isalnum() or sign in "-_." else "-" for sign in name)
    return plain.lstrip(".") or "-"
