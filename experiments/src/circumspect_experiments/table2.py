"""The half of the paper's Table 2 on ModelNet10."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from circumspect import __version__
from circumspect.classification import GridSpec
from circumspect.datasets import GridCache, ObjectSet
from circumspect.evaluation.figures import draw_confusion, save_figure, yaws_of
from circumspect.evaluation.markdown import table
from circumspect.evaluation.yaw_sweep import YawSweep, spread_yaws
from circumspect_experiments.comparison_figures import draw_accuracies_over_yaw
from circumspect_experiments.experiment import Experiment
from circumspect_experiments.stages import Watched, measured, trained, write_report
from circumspect_experiments.training_record import training_record, training_table
from circumspect_experiments.whole_set import ANGLES_DEG, PUBLISHED_ACCURACY, require_modelnet10

NETS = {"rwmp": "moon2018", "max": "moon2018-max"}
OURS = "planes"


@dataclass(frozen=True, kw_only=True)
class Table2(Experiment):
    """Settings of the experiment; see `Experiment`.

    Attributes:
        shape: Shape of the grids; those of the paper have 32 cells.
    """

    shape: tuple[int, int, int] = (32, 32, 32)

    @property
    def trained_nets(self) -> tuple[str, ...]:
        """See `Experiment.trained_nets`; the half on the robot's set also trains our network."""
        return (*NETS.values(), OURS)


def reproduce_table2(
    train: ObjectSet,
    test: ObjectSet,
    how: Table2,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> dict[str, Any]:
    """Train the four networks at 0°, and test them at the paper's angles and over all yaws.

    Finished stages in the folder are kept, so that an interrupted experiment resumes.

    Args:
        train: ModelNet10's training split; part of it is held back to choose the best epoch.
        test: Its test split.
        how: Settings.
        folder: For the runs, `table2.md`, `table2.json` and the figures.
        watched: Receives the progress.
        cache: Cache for grids.

    Returns:
        Content of `table2.json`.

    Raises:
        InputError: The set lacks classes of ModelNet10, or has others; or the folder holds results
            of another experiment.
        OutputError: It can not be written.
    """
    require_modelnet10(train, test)
    angles, around, records = {}, {}, {}
    for kind, pool in PUBLISHED_ACCURACY:
        name = f"{kind}-{pool}"
        settings = how.settings(NETS[pool])
        with watched.training(name, settings.epochs) as observer:
            input_spec = GridSpec(kind, how.shape)
            weights = trained(
                train, settings, input_spec, folder / name / "training", observer, cache
            )
        records[kind, pool] = training_record(weights)
        with watched.measuring(f"{name} at the paper's angles") as progress:
            at = folder / name / "angles"
            angles[kind, pool] = measured(weights, test, list(ANGLES_DEG), at, progress)
        with watched.measuring(f"{name} all around") as progress:
            yaws, at = spread_yaws(how.yaw_count), folder / name / "around"
            around[kind, pool] = measured(weights, test, yaws, at, progress)
    for (kind, pool), sweep in angles.items():
        figure = draw_confusion(sweep.confusion, sweep.classes, yaws_of(sweep))
        save_figure(figure, folder / _confusions(kind, pool))
    sweeps = {f"{kind}, {pool}": sweep for (kind, pool), sweep in around.items()}
    save_figure(draw_accuracies_over_yaw(sweeps), folder / "accuracy_over_yaw.png")
    document = _document(angles, around, records, how)
    write_report(document, _markdown(document), folder, "table2")
    return document


def _document(
    angles: dict[tuple[str, str], YawSweep],
    around: dict[tuple[str, str], YawSweep],
    records: dict[tuple[str, str], dict[str, float]],
    how: Table2,
) -> dict[str, Any]:
    rows = []
    for (kind, pool), published in PUBLISHED_ACCURACY.items():
        sweep, whole = angles[kind, pool], around[kind, pool]
        rows.append(
            {
                "grid": kind,
                "pool": pool,
                "yaw_deg": list(ANGLES_DEG),
                "paper": list(published),
                "accuracy": sweep.accuracy.tolist(),
                "around": {"yaws": len(whole.yaw_deg), **whole.summary},
                "training": records[kind, pool],
            }
        )
    first = next(iter(angles.values()))
    return {
        "circumspect": __version__,
        "command": how.command("table2 --data modelnet10"),
        "objects": len(first.labels),
        "precision": how.precisions,
        "seed": how.seed,
        "rows": rows,
    }


def _markdown(document: dict[str, Any]) -> str:
    head = ["grid, pooling", *(f"{angle:.0f}°" for angle in ANGLES_DEG)]
    head += ["mean", "worst", "flips"]
    rows = []
    for row in document["rows"]:
        cells = [
            f"{ours:.3f} ({paper:.2f})"
            for ours, paper in zip(row["accuracy"], row["paper"], strict=True)
        ]
        whole = row["around"]
        cells += [f"{whole['mean']:.3f}", f"{whole['worst']:.3f}", f"{whole['flip_rate']:.0%}"]
        rows.append([f"{row['grid']}, {row['pool']}", *cells])
    yaws = document["rows"][0]["around"]["yaws"]
    return (
        f"# Table 2: ModelNet10\n\n`{document['command']}`\n\n"
        f"Accuracy on {document['objects']} test objects, in brackets that of the paper. "
        f"Trained at 0° alone, {document['precision']}, seed {document['seed']}. Mean, worst and "
        f"the share of objects whose label changes are over {yaws} yaws, each at another fraction "
        "of a cell.\n\n"
        + table(head, rows)
        + "\n\n"
        + training_table([row[0] for row in rows], [row["training"] for row in document["rows"]])
        + "\n![Accuracy over all yaws](accuracy_over_yaw.png)\n"
        + "".join(
            f"\n![Confusions, {kind}, {pool}]({_confusions(kind, pool)})\n"
            for kind, pool in PUBLISHED_ACCURACY
        )
    )


def _confusions(kind: str, pool: str) -> str:
    """File name of the figure."""
    return f"confusion_{kind}_{pool}.png"
