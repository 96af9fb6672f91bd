"""`circumspect data convert`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from circumspect.errors import InputError, MissingExtraError


def convert_set(
    source: str,
    url: str,
    net: str,
    replicas: int | None,
    shard_size: int,
    seed: int,
    workers: int | None,
    cluster: str | None,
) -> dict[str, int]:
    """Make the shards of a set for a network, with progress; see `Data` for the arguments.

    Returns:
        See `convert`.
    """
    try:
        from circumspect.nets.registry import net_spec
        from circumspect.training import TrainingSettings
    except ImportError as error:
        raise MissingExtraError(error.name or "torch", "train") from error
    from circumspect.classification import GridRecipe
    from circumspect.classification.shipped import shipped_name
    from circumspect.cli.job_pool import opened_pool, seen_from
    from circumspect.cli.progress import progress_bar
    from circumspect.evaluation.predictor import load_predictor
    from circumspect.gathering.conversion import ConversionSettings, convert

    if shipped_name(net) is not None or Path(net).exists():
        recipe, meant = load_predictor(net).recipe, TrainingSettings()
    else:
        spec = net_spec(net)
        recipe, meant = spec.recipe, TrainingSettings(**{**spec.training, "net": spec.name})
    if not isinstance(recipe, GridRecipe):
        raise InputError(f"{net} takes points; shards hold grids")
    if shipped_name(net) is not None or Path(net).exists():
        recipe, meant = load_predictor(net).recipe, TrainingSettings()
    else:
        spec = net_spec(net)
        recipe, meant = spec.recipe, TrainingSettings.of_net(spec)
    if not isinstance(recipe, GridRecipe):
        raise InputError(f"{net} takes points; shards hold grids")
    settings = ConversionSettings(
        recipe, meant.changes(recipe.margin), meant.replicas if replicas is None else replicas,
        shard_size, seed,
    )  # fmt: skip
    with (
        opened_pool(workers, cluster) as pool,
        _local(source) as folder,
        progress_bar(f"shards, {pool.name}") as show,
    ):
        return convert(folder, seen_from(cluster, url), settings, pool, show)


@contextmanager
def _local(source: str) -> Iterator[Path]:
    """A set as a folder; one in an object store is copied."""
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
