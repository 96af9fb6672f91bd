"""The training loop."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
import torch
from accelerate import Accelerator
from torch import Tensor, nn
from torch.nn import functional
from torch.optim.swa_utils import AveragedModel

from circumspect.classification import GridRecipe, InputRecipe
from circumspect.classification.model_description import OBJECTS
from circumspect.datasets import GridCache, ObjectSet
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.errors import InputError
from circumspect.folder_lock import locked_folder
from circumspect.nets import Checkpoint, build_net
from circumspect.nets.headed_planes import Headed
from circumspect.nets.registry import net_spec, require_turnable
from circumspect.nets.state_channels import state_channels
from circumspect.training.draws import learning_rate_at
from circumspect.training.mixing import mixed
from circumspect.training.optimisation import forgetful_average, optimizer_for
from circumspect.training.progress import Progress
from circumspect.training.resume import load_state, save_state
from circumspect.training.run_config import BEST, STATE, claim_folder, run_config
from circumspect.training.run_log import RunLog
from circumspect.training.scan_data import scan_data
from circumspect.training.settings import TrainingSettings
from circumspect.training.sharded_training import ShardedTraining
from circumspect.training.training_data import TrainingData, object_data

FEWEST_TO_CHOOSE = 100
"""Held-back objects from which on they choose the epoch; of fewer it would be luck."""
STATE_INTERVAL_S = 300.0
"""Between saved states within an epoch."""


class TrainingObserver(Protocol):
    """What a progress display wants to know."""

    def preparing(self, done: int, total: int) -> None:
        """Grids are being made."""

    def stepped(self, epoch: int, step: int, steps: int, loss: float) -> None:
        """A step was taken."""

    def finished_epoch(self, row: dict[str, float]) -> None:
        """An epoch is over."""


@dataclass
class _Run:
    """What the steps of one run share."""

    settings: TrainingSettings
    accelerator: Accelerator
    net: nn.Module
    averaged: AveragedModel
    optimizer: torch.optim.Optimizer
    data: TrainingData
    weights: Tensor | None
    steps: int


def train(
    objects: ObjectSet | ShardedTraining,
    settings: TrainingSettings,
    folder: Path,
    observer: TrainingObserver,
    cache: GridCache | None = None,
    recipe: InputRecipe | None = None,
    stop_after: int | None = None,
    catalogues: Sequence[LabelledSurfaces] = (),
) -> Checkpoint:
    """Train a network; a run that was interrupted goes on where it stopped.

    Args:
        objects: The official training split; part of it is held back for validation. Or a set
            in shards, which was divided when they were made.
        settings: Of the run.
        folder: Of the run: settings, log, state and the best checkpoint.
        observer: Told of the progress.
        cache: Where grids are kept.
        recipe: What the network is shown; None means what it is meant for.
        stop_after: Stop after this many epochs as if interrupted.
        catalogues: Further objects, for a run on simulated scans.

    Returns:
        The checkpoint of the epoch that is kept: the best one on held-back objects where at least
        `FEWEST_TO_CHOOSE` are held back, else the last.

    Raises:
        InputError: The folder holds a run with other settings, one that is finished and has no
            state to go on from, or the middle of an epoch that another number of processes shares;
            the recipe's margin is none of the sizes that are trained on; the
            network can not be trained at random yaw; or the loss or the weights are no longer
            finite.
        OutputError: The folder can not be written, or holds files of something else.
    """
    recipe = recipe or recipe_for(settings)
    if not settings.scans:
        settings.require_margin(recipe.margin)
    if settings.random_yaw:
        require_turnable(settings.net)
    # Of the processes that train together the first alone writes.
    writes = os.environ.get("RANK", "0") == "0"
    with locked_folder(folder) if writes else nullcontext():
        claim_folder(folder, run_config(settings, recipe, objects.digest, catalogues))
        run = _prepare(objects, catalogues, settings, recipe, cache or GridCache(), observer)
        _train_epochs(run, recipe, folder, observer, stop_after)
    return Checkpoint.load(folder / BEST)


def _train_epochs(
    run: _Run,
    recipe: InputRecipe,
    folder: Path,
    observer: TrainingObserver,
    stop_after: int | None,
) -> None:
    """The epochs that are left."""
    settings, progress = run.settings, _resumed(run, folder)
    log = RunLog(folder, progress.history) if run.accelerator.is_main_process else None
    end = settings.epochs if stop_after is None else min(stop_after, settings.epochs)
    for epoch in range(progress.epoch, end):
        row = _train_epoch(run, progress, observer, folder)
        _require_finite_weights(run, epoch)
        if run.data.examiner:
            with _precise(run):
                row |= run.data.examiner.examine(run.averaged.module)
        if log:
            kept = run.data.held_back < FEWEST_TO_CHOOSE or _is_best(row, log.history)
            # First, so that a network without a state is known to be of a cut first epoch.
            log.add(row)
            if kept:
                _checkpoint(run, recipe, row).save(folder / BEST)
            _save(run, folder, progress.next_epoch(row))
            observer.finished_epoch(row)
        progress = progress.next_epoch(row)
        run.accelerator.wait_for_everyone()
    if log:
        log.close()


def _is_best(row: dict[str, float], history: list[dict[str, float]]) -> bool:
    """Better on validation than all epochs before; of equal accuracies the smallest loss counts."""
    return all(_merit(row) > _merit(before) for before in history)


def _merit(row: dict[str, float]) -> tuple[float, float]:
    return row["validation_accuracy"], -row["validation_loss"]


def _train_epoch(
    run: _Run, progress: Progress, observer: TrainingObserver, folder: Path
) -> dict[str, float]:
    """The rest of an epoch.

    Every rank and every step has a chance of its own, so that a resumed run repeats it.
    """
    settings, accelerator, epoch = run.settings, run.accelerator, progress.epoch
    start = saved = time.perf_counter()
    run.net.train()
    for step, (inputs, targets) in enumerate(_batches(run, epoch, progress.step), progress.step):
        torch.manual_seed(_seed_of(settings.seed, epoch, step, accelerator.process_index))
        rate = learning_rate_at(
            epoch * run.steps + step,
            settings.epochs * run.steps,
            settings.learning_rate,
            settings.warm_up,
        )
        for group in run.optimizer.param_groups:
            group["lr"] = rate
        with _precise(run):
            answer = run.net(*inputs)
        logits, loss = _judged(answer, targets, settings, run.weights)
        accelerator.backward(loss)
        accelerator.clip_grad_norm_(run.net.parameters(), settings.gradient_norm)
        run.optimizer.step()
        run.optimizer.zero_grad(set_to_none=True)
        # Without averaging only the last step's weights are kept.
        if settings.averaging > 0 or step + 1 == run.steps:
            run.averaged.update_parameters(accelerator.unwrap_model(run.net))
        hits = int((logits.argmax(1) == targets.argmax(1)).sum())
        progress.add(_finite(loss.item(), epoch), hits, len(targets))
        observer.stepped(epoch, step + 1, run.steps, loss.item())
        now = time.perf_counter()
        if now - saved > STATE_INTERVAL_S and step + 1 < run.steps:
            progress.seconds, start, saved = progress.seconds + now - start, now, now
            _save(run, folder, progress)
    progress.seconds += time.perf_counter() - start
    return progress.row()


def _seed_of(*numbers: int) -> int:
    return int(np.random.SeedSequence(numbers).generate_state(1, np.uint64)[0])


def _finite(loss: float, epoch: int) -> float:
    if not math.isfinite(loss):
        raise _diverged(f"the loss is {loss} in epoch {epoch + 1}")
    return loss


def _require_finite_weights(run: _Run, epoch: int) -> None:
    """No loss is computed after an epoch's last step that would show what it broke."""
    for name, value in run.averaged.module.state_dict().items():
        if not value.isfinite().all():
            raise _diverged(f"{name} is no longer finite after epoch {epoch + 1}")


def _diverged(found: str) -> InputError:
    return InputError(f"{found}: the training diverged; train anew with a lower --learning-rate")


def _precise(run: _Run) -> torch.autocast:
    """The precision that the settings ask for."""
    wanted = run.settings.precision == "bf16"
    return torch.autocast(run.accelerator.device.type, torch.bfloat16, wanted)


def _judged(
    answer: Tensor | Headed,
    targets: Tensor,
    settings: TrainingSettings,
    weights: Tensor | None,
) -> tuple[Tensor, Tensor]:
    """The logits and the loss."""
    logits = answer.logits if isinstance(answer, Headed) else answer
    loss = functional.cross_entropy(
        logits.float(), targets, weights, label_smoothing=settings.label_smoothing
    )
    if isinstance(answer, Headed):
        # `require_turnable` has refused a random yaw: the 0° of all objects lies in cell 0.
        ahead = torch.zeros(len(targets), dtype=torch.long, device=targets.device)
        loss = loss + settings.heading * functional.cross_entropy(answer.heading.float(), ahead)
    return logits, loss


def _batches(run: _Run, epoch: int, first: int) -> Iterator[tuple[list[Tensor], Tensor]]:
    """This process' share of the epoch's batches: inputs (b, …) and targets (b, c), float32."""
    settings, accelerator = run.settings, run.accelerator
    rank, world = accelerator.process_index, accelerator.num_processes
    batches = run.data.batches.of_epoch(epoch, first, rank, world)
    for step, (inputs, targets) in enumerate(batches, first):
        tensors = [torch.from_numpy(one).to(accelerator.device) for one in (*inputs, targets)]
        tensors[0] = state_channels(tensors[0]) if len(inputs) > 1 else tensors[0].float()
        rng = np.random.default_rng([settings.seed, epoch, step])
        *shown, targets = mixed(tensors, rng) if rng.random() < settings.mixing else tensors
        yield shown, targets


def _require_a_batch(objects: int, settings: TrainingSettings, fewest: int) -> None:
    """Batch norm needs two objects a process and batch."""
    if settings.batch_size < fewest:
        raise InputError(
            f"--batch-size {settings.batch_size}: batch norm needs two objects a process and "
            f"batch; give {fewest} or more"
        )
    if objects < fewest:
        held = ", or hold none back with --no-validation" if settings.validation else ""
        raise InputError(
            f"objects left to train on: {objects}; batch norm needs {fewest} at least: add "
            f"objects{held}"
        )


def recipe_for(settings: TrainingSettings) -> InputRecipe:
    """What a network is meant to be shown; of simulated scans also visibility and size.

    A network that takes neither is shown scans as it is shown complete objects.

    Raises:
        InputError: No network of that name.
    """
    spec = net_spec(settings.net)
    if not settings.scans or not spec.takes_context:
        return spec.recipe
    assert isinstance(spec.recipe, GridRecipe)
    return replace(spec.recipe, visibility=True, metric=True)


def _prepare(
    objects: ObjectSet | ShardedTraining,
    catalogues: Sequence[LabelledSurfaces],
    settings: TrainingSettings,
    recipe: InputRecipe,
    cache: GridCache,
    observer: TrainingObserver,
) -> _Run:
    accelerator = Accelerator(mixed_precision="no")  # `precision` is ours to apply.
    fewest = 2 * accelerator.num_processes
    _require_a_batch(len(objects), settings, fewest)
    # Before the grids, which take long: a network may not be made for their cells.
    torch.manual_seed(settings.seed)
    classes = len(objects.classes) + settings.scans
    net = build_net(settings.net, classes, recipe)
    with accelerator.main_process_first():
        if isinstance(objects, ShardedTraining):
            data = objects.data(settings, accelerator.device, accelerator.num_processes)
        elif settings.scans:
            data = scan_data(
                objects, catalogues, settings, recipe, accelerator.device, observer.preparing,
                cache.folder / "scans",
            )  # fmt: skip
        else:
            data = object_data(
                objects, settings, recipe, cache, accelerator.device, observer.preparing
            )
    _require_a_batch(data.count, settings, fewest)
    optimizer = optimizer_for(net, settings)
    net, optimizer = accelerator.prepare(net, optimizer)
    averaged = AveragedModel(
        accelerator.unwrap_model(net),
        avg_fn=forgetful_average(settings.averaging),
        use_buffers=True,
    )
    weights = None
    if data.class_weights is not None:
        weights = torch.tensor(data.class_weights, device=accelerator.device)
    steps = data.batches.steps(accelerator.num_processes)
    return _Run(settings, accelerator, net, averaged, optimizer, data, weights, steps)


def _checkpoint(run: _Run, recipe: InputRecipe, row: dict[str, float]) -> Checkpoint:
    weights = {name: value.cpu() for name, value in run.averaged.module.state_dict().items()}
    training = {
        "settings": run.settings.to_dict(), "reached": row, "data": run.data.digest,
        OBJECTS: run.data.fitted,
    }  # fmt: skip
    return Checkpoint(run.settings.net, run.data.classes, recipe, weights, training)


def _modules(run: _Run) -> dict[str, nn.Module]:
    return {"net": run.accelerator.unwrap_model(run.net), "averaged": run.averaged}


def _save(run: _Run, folder: Path, progress: Progress) -> None:
    if run.accelerator.is_main_process:
        save_state(folder / STATE, _modules(run), run.optimizer, asdict(progress))


def _resumed(run: _Run, folder: Path) -> Progress:
    """Restore the state of an interrupted run."""
    processes, path = run.accelerator.num_processes, folder / STATE
    if not path.exists():
        return Progress([], processes=processes)
    found = load_state(path, _modules(run), run.optimizer, run.accelerator.device)
    progress = Progress(**found)
    if progress.step and progress.processes != processes:
        raise InputError(
            f"{path}: is of the middle of an epoch that {progress.processes} processes share; "
            f"resume with as many, not with {processes}"
        )
    return replace(progress, processes=processes)
