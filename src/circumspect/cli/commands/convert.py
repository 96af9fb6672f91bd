"""`circumspect data convert`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from circumspect.errors import InputError, MissingExtraError


@dataclass(frozen=True)
class Conversion:
    """Settings of the conversion of a set into shards."""

    net: str = "planes"
    """convert only: network for which grids are made (see `circumspect nets`), or a classifier to
    evaluate on them: a shipped one, an ONNX file, or the folder of a run."""
    replicas: int | None = None
    """convert only: augmented variants of each training object; the network's usual number by
    default."""
    shard_size: int = 4096
    """convert only: number of grids in a shard."""
    seed: int = 0
    """convert only: random seed of the augmentation and of the order of objects."""
    workers: int | None = None
    """convert only: number of processes; one per core by default."""
    cluster: str | None = None
    """convert only: Ray cluster, see `circumspect gather`."""


def convert_set(
    source: str, url: str, how: Conversion, begun: Callable[[], None] = lambda: None
) -> dict[str, int]:
    """Make the shards of a set for a network, and display the progress.

    Args:
        source: Path, or URL of a gathered set.
        url: Path or URL of the shards.
        how: Settings.
        begun: Called before the first shard is made, if the destination has no other shards.

    Returns:
        See `convert`.
    """
    try:
        from circumspect.nets.registry import net_spec
        from circumspect.training import TrainingSettings
    except ImportError as error:
        raise MissingExtraError(error.name or "torch", "train") from error
    from circumspect.classification import GridSpec
    from circumspect.classification.shipped import shipped_name
    from circumspect.cli.job_pool import opened_pool, seen_from
    from circumspect.cli.progress import progress_bar
    from circumspect.evaluation.predictor import load_predictor
    from circumspect.gathering.conversion import ConversionSettings, convert

    if shipped_name(how.net) is not None or Path(how.net).exists():
        input_spec, defaults = load_predictor(how.net).input_spec, TrainingSettings()
    else:
        spec = net_spec(how.net)
        input_spec, defaults = spec.input_spec, TrainingSettings.of_net(spec)
    if not isinstance(input_spec, GridSpec):
        raise InputError(f"{how.net} takes points; shards hold grids")
    settings = ConversionSettings(
        input_spec, defaults.changes(input_spec.margin),
        defaults.replicas if how.replicas is None else how.replicas, how.shard_size, how.seed,
    )  # fmt: skip
    first = iter([begun])
    with (
        opened_pool(how.workers, how.cluster) as pool,
        _local(source) as folder,
        progress_bar(f"shards, {pool.name}") as show,
    ):

        def report(done: int, total: int) -> None:
            for once in first:
                once()
            show(done, total)

        return convert(folder, seen_from(how.cluster, url), settings, pool, report)


@contextmanager
def _local(source: str) -> Iterator[Path]:
    """The folder of a set; a set in an object store is copied to a local folder."""
    from circumspect.gathering.set_place import place_of

    if "://" not in source:
        yield Path(source)
        return
    place = place_of(source)
    scans = [scan for scan in place.scans() if "cloud" in scan.files]
    if not scans:
        raise InputError(f"{source}: holds no gathered set")
    with place.local(scans) as folder:
        yield folder
