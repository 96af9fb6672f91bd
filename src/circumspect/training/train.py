"""The training loop."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
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

from circumspect.classification import GridSpec, InputSpec
from circumspect.classification.model_description import OBJECTS
from circumspect.datasets import GridCache, ObjectSet
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.errors import InputError
from circumspect.folder_lock import locked_folder
from circumspect.nets import Checkpoint, build_net
from circumspect.nets.planes import Headed
from circumspect.nets.registry import net_spec, require_turnable
from circumspect.nets.state_channels import state_channels
from circumspect.training.batches import mixed
from circumspect.training.draws import learning_rate_at
from circumspect.training.optimisation import exponential_average, optimizer_for
from circumspect.training.resume import Progress, load_state, save_state
from circumspect.training.run_config import BEST, STATE, claim_folder, run_config
from circumspect.training.run_log import RunLog
from circumspect.training.scan_data import scan_data
from circumspect.training.settings import TrainingSettings
from circumspect.training.sharded_training import ShardedTraining
from circumspect.training.training_data import TrainingData, object_data

MIN_VALIDATION_OBJECTS = 100
"""Minimum number of held-back objects for the selection of an epoch; fewer are too noisy."""
STATE_INTERVAL_S = 300.0
"""Time between saved states within an epoch [s]."""


class TrainingObserver(Protocol):
    """Observer of a run, for a display."""

    def preparing(self, done: int, total: int) -> None:
        """Called while inputs are prepared."""

    def stepped(self, epoch: int, step: int, steps: int, loss: float) -> None:
        """Called after each step."""

    def finished_epoch(self, row: dict[str, float]) -> None:
        """Called after each epoch."""


@dataclass
class _Run:
    """The state that all steps of a run share."""

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
    input_spec: InputSpec | None = None,
    stop_after: int | None = None,
    catalogues: Sequence[LabelledSurfaces] = (),
    claimed: Callable[[], None] | None = None,
) -> Checkpoint:
    """Train a network; an interrupted run resumes.

    Args:
        objects: The official training split, from which validation objects are held back; or a
            sharded set, which is split already.
        settings: Settings of the run.
        folder: Folder of the run, for settings, log, state and the best checkpoint.
        observer: Receives the progress.
        cache: Cache of the grids.
        input_spec: The network's inputs; None means its default.
        stop_after: Stop after this many epochs as if interrupted.
        catalogues: Additional objects for simulated scans.
        claimed: Called by the first process once the folder belongs to the run.

    Returns:
        The checkpoint of the best epoch on held-back objects if at least `MIN_VALIDATION_OBJECTS`
        are held back, else of the last epoch.

    Raises:
        InputError: The folder contains a run with other settings, a finished run without a state to
            resume from, or an unfinished epoch with another number of processes; the margin of the
            input specification is outside the sizes in training; the network cannot be trained at
            random yaw; or the loss or the weights are no longer finite.
        OutputError: The folder cannot be written, or contains foreign files.
    """
    input_spec = input_spec or input_spec_for(settings)
    if not settings.scans:
        settings.require_margin(input_spec.margin)
    if settings.random_yaw:
        require_turnable(settings.net)
    # Only the first of several processes writes.
    writes = os.environ.get("RANK", "0") == "0"
    with locked_folder(folder) if writes else nullcontext():
        claim_folder(folder, run_config(settings, input_spec, objects.digest, catalogues), writes)
        if writes and claimed is not None:
            claimed()
        run = _prepare(objects, catalogues, settings, input_spec, cache or GridCache(), observer)
        _train_epochs(run, input_spec, folder, observer, stop_after)
    return Checkpoint.load(folder / BEST)


def _train_epochs(
    run: _Run,
    input_spec: InputSpec,
    folder: Path,
    observer: TrainingObserver,
    stop_after: int | None,
) -> None:
    """Train the remaining epochs."""
    settings, progress = run.settings, _resumed(run, folder)
    log = RunLog(folder, progress.history) if run.accelerator.is_main_process else None
    end = settings.epochs if stop_after is None else min(stop_after, settings.epochs)
    for epoch in range(progress.epoch, end):
        row = _train_epoch(run, progress, observer, folder)
        _require_finite_weights(run, epoch)
        if run.data.examiner:
            with _autocast(run):
                row |= run.data.examiner.examine(run.averaged.module)
        if log:
            kept = run.data.held_back < MIN_VALIDATION_OBJECTS or _is_best(row, log.history)
            # Logged first, so that a network without a state belongs to an interrupted first epoch.
            log.add(row)
            if kept:
                _checkpoint(run, input_spec, row).save(folder / BEST)
            _save(run, folder, progress.next_epoch(row))
            observer.finished_epoch(row)
        progress = progress.next_epoch(row)
        run.accelerator.wait_for_everyone()
    if log:
        log.close()


def _is_best(row: dict[str, float], history: list[dict[str, float]]) -> bool:
    """Whether validation is better than in all earlier epochs; the smaller loss breaks ties."""
    return all(_validation_rank(row) > _validation_rank(before) for before in history)


def _validation_rank(row: dict[str, float]) -> tuple[float, float]:
    return row["validation_accuracy"], -row["validation_loss"]


def _train_epoch(
    run: _Run, progress: Progress, observer: TrainingObserver, folder: Path
) -> dict[str, float]:
    """Train the rest of an epoch.

    Every rank and every step has its own random generator, so that a resumed run is reproducible.
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
        with _autocast(run):
            answer = run.net(*inputs)
        logits, loss = _logits_and_loss(answer, targets, settings, run.weights)
        accelerator.backward(loss)
        accelerator.clip_grad_norm_(run.net.parameters(), settings.gradient_norm)
        run.optimizer.step()
        run.optimizer.zero_grad(set_to_none=True)
        # Without averaging only the weights of the last step are used.
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
    """Check the weights, because no loss is computed after the last step of an epoch."""
    for name, value in run.averaged.module.state_dict().items():
        if not value.isfinite().all():
            raise _diverged(f"{name} is no longer finite after epoch {epoch + 1}")


def _diverged(found: str) -> InputError:
    return InputError(f"{found}: the training diverged; train again with a lower --learning-rate")


def _autocast(run: _Run) -> torch.autocast:
    """Autocast with the precision of the settings."""
    wanted = run.settings.precision == "bf16"
    return torch.autocast(run.accelerator.device.type, torch.bfloat16, wanted)


def _logits_and_loss(
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
        # `require_turnable` refuses a random yaw, so that 0° of all objects is in cell 0.
        ahead = torch.zeros(len(targets), dtype=torch.long, device=targets.device)
        loss = loss + settings.heading * functional.cross_entropy(answer.heading.float(), ahead)
    return logits, loss


def _batches(run: _Run, epoch: int, first: int) -> Iterator[tuple[list[Tensor], Tensor]]:
    """This process' part of the epoch's batches: inputs (b, …) and targets (b, c), float32."""
    settings, accelerator = run.settings, run.accelerator
    rank, world = accelerator.process_index, accelerator.num_processes
    batches = run.data.batches.of_epoch(epoch, first, rank, world)
    for step, (inputs, targets) in enumerate(batches, first):
        tensors = [torch.from_numpy(one).to(accelerator.device) for one in (*inputs, targets)]
        tensors[0] = state_channels(tensors[0]) if len(inputs) > 1 else tensors[0].float()
        rng = np.random.default_rng([settings.seed, epoch, step])
        *shown, targets = mixed(tensors, rng) if rng.random() < settings.mixing else tensors
        yield shown, targets


def _require_a_batch(objects: int, settings: TrainingSettings, min_objects: int) -> None:
    """Check that batch norm gets two objects per process and batch."""
    if settings.batch_size < min_objects:
        raise InputError(
            f"--batch-size {settings.batch_size}: batch norm needs two objects a process and "
            f"batch; give {min_objects} or more"
        )
    if objects < min_objects:
        held = ", or hold none back with --no-validation" if settings.validation else ""
        raise InputError(
            f"objects left to train on: {objects}; batch norm needs {min_objects} at least: add "
            f"objects{held}"
        )


def input_spec_for(settings: TrainingSettings) -> InputSpec:
    """The default inputs of a network, with visibility and size for simulated scans.

    A network that does not take them is trained on scans with the inputs of complete objects.

    Raises:
        InputError: The network does not exist.
    """
    spec = net_spec(settings.net)
    if not settings.scans or not spec.takes_context:
        return spec.input_spec
    assert isinstance(spec.input_spec, GridSpec)
    return replace(spec.input_spec, visibility=True, metric=True)


def _prepare(
    objects: ObjectSet | ShardedTraining,
    catalogues: Sequence[LabelledSurfaces],
    settings: TrainingSettings,
    input_spec: InputSpec,
    cache: GridCache,
    observer: TrainingObserver,
) -> _Run:
    accelerator = Accelerator(mixed_precision="no")  # `_autocast` applies the precision.
    min_objects = 2 * accelerator.num_processes
    _require_a_batch(len(objects), settings, min_objects)
    # Built before the grids, which take long, because the network may not accept their shape.
    torch.manual_seed(settings.seed)
    classes = len(objects.classes) + settings.scans
    net = build_net(settings.net, classes, input_spec)
    with accelerator.main_process_first():
        if isinstance(objects, ShardedTraining):
            data = objects.data(settings, accelerator.device, accelerator.num_processes)
        elif settings.scans:
            data = scan_data(
                objects, catalogues, settings, input_spec, accelerator.device, observer.preparing,
                cache.folder / "scans",
            )  # fmt: skip
        else:
            data = object_data(
                objects, settings, input_spec, cache, accelerator.device, observer.preparing
            )
    _require_a_batch(data.count, settings, min_objects)
    optimizer = optimizer_for(net, settings)
    net, optimizer = accelerator.prepare(net, optimizer)
    averaged = AveragedModel(
        accelerator.unwrap_model(net),
        avg_fn=exponential_average(settings.averaging),
        use_buffers=True,
    )
    weights = None
    if data.class_weights is not None:
        weights = torch.tensor(data.class_weights, device=accelerator.device)
    steps = data.batches.steps(accelerator.num_processes)
    return _Run(settings, accelerator, net, averaged, optimizer, data, weights, steps)


def _checkpoint(run: _Run, input_spec: InputSpec, row: dict[str, float]) -> Checkpoint:
    weights = {name: value.cpu() for name, value in run.averaged.module.state_dict().items()}
    training = {
        "settings": run.settings.to_dict(), "reached": row, "data": run.data.digest,
        OBJECTS: run.data.fitted,
    }  # fmt: skip
    return Checkpoint(run.settings.net, run.data.classes, input_spec, weights, training)


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
