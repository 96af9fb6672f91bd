"""Tables of the scans, as Markdown and JSON."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.complete_clouds import classifier_of, complete_answers
from benchmarks.provenance import made_by
from benchmarks.report import machine
from circumspect.evaluation.markdown import table
from circumspect.storage import atomic_open, write_json

Record = dict[str, Any]
LIMITS = {"ate_mm": 10.0, "yaw_deg": 0.5, "ratio": 0.2, "chamfer_mm": 6.0, "completeness": 0.9}
"""Target values; a figure that misses its target is bold."""
SPREAD = ("median", "p95", "worst")
MIN_PATH_M = 1.0
"""Shorter paths [m] do not determine errors of rotation."""
MAX_FRAME_MS = 300
"""The robot waits for frames that take longer [ms]."""


def write_tables(found: Sequence[Record], folder: Path, command: str, data: Path) -> None:
    """Write `scans.md` and `scans.json`; tables of suites that were not run are left out."""
    by_suite: dict[str, list[Record]] = defaultdict(list)
    for record in found:
        by_suite[record["suite"]].append(record)
    document: dict[str, Any] = {"command": command, "machine": machine()}
    parts = [f"# Scans\n\n`{command}`; what the figures mean: [scans](../../docs/scans.md)\n"]
    by_suite["paths of planners"] = by_suite["planners"]
    makers: tuple[tuple[str, str, Callable[[list[Record]], tuple[str, Any]]], ...] = (
        ("furniture", "Trajectory and shape", trajectory_and_shape),
        ("planners", "Distance driven", distances),
        ("paths of planners", "Trajectory and shape by planner", by_planner),
        ("modelnet", "Answers on ModelNet10's test objects", partial(answers, data=data)),
        ("timing", "Time a frame [ms]", times),
    )
    for suite, title, maker in makers:
        if by_suite[suite]:
            text, figures = maker(by_suite[suite])
            parts.append(f"## {title}\n\n{made_by(by_suite[suite])}\n\n{text}\n")
            document[suite] = figures
    parts.append("".join(f"- {key}: {value}\n" for key, value in document["machine"].items()))
    with atomic_open(folder / "scans.md") as stream:
        stream.write("\n".join(parts))
    write_json(folder / "scans.json", document)


def by_planner(found: list[Record]) -> tuple[str, Any]:
    """The same errors for each planner; their frames are further apart."""
    far = [record for record in found if record.get("distance_m", 0.0) >= MIN_PATH_M]
    text, figures = trajectory_and_shape(far, "planner", "planner") if far else ("", {})
    note = f"Of scans of at least {MIN_PATH_M:g} m: a shorter path can be turned anyhow to fit.\n\n"
    return note + text, figures


def trajectory_and_shape(
    found: list[Record], key: str = "true_label", of: str = "category"
) -> tuple[str, Any]:
    """Errors per category and in all: median and worst.

    Args:
        found: Records of the scans.
        key: Key of the records; scans with the same value form a row.
        of: Heading of the rows.
    """
    groups = _grouped(found, key)
    groups["all"] = found
    rows, figures = [], {}
    for name, some in groups.items():
        f = figures[name] = _errors(some)
        rows.append([
            name.replace("_", " "), str(f["scans"]),
            _marked(f["ate_mm"], "ate_mm"), _marked(f["yaw_deg"], "yaw_deg", 2),
            f"{f['odometry_mm']['median']:.0f}", _marked(f["ratio"], "ratio", 3),
            _marked(f["chamfer_mm"], "chamfer_mm"),
            _marked(f["completeness"], "completeness", 3, -1),
            _plain(f["nees"], 1), _while_reliable(f),
            f"{f['correct']}/{f['scans']}",
        ])  # fmt: skip
    head = [
        of, "scans", "ATE [mm]", "yaw [°]", "odometry [mm]", "ATE / odometry",
        "chamfer [mm]", "completeness", "NEES", "worst while reliable [mm]", "correct",
    ]  # fmt: skip
    note = (
        "Median (worst) of the scans; ATE and yaw are root mean squares over a scan's frames. "
        "Bold: the worst scan misses 10 mm, 0.5°, a fifth of odometry, 6 mm or 90 %.\n\n"
    )
    shaped = [
        r for r in found if r.get("ate_rmse_m") is not None and r.get("chamfer_m") is not None
    ]
    if not shaped:
        return note + table(head, rows), figures
    figures["together"] = together = _together(shaped)
    return f"{note}{table(head, rows)}\n\n{_summary_line(together)}", figures


def _together(shaped: list[Record]) -> dict[str, Any]:
    """Figures over all measured scans: root mean squares or means, and the number of scans within
    the limits.
    """
    ate, odometry, chamfer = (
        np.array([1e3 * r[name] for r in shaped])
        for name in ("ate_rmse_m", "ate_odometry_rmse_m", "chamfer_m")
    )
    yaw, completeness = (
        np.array([r[name] for r in shaped]) for name in ("yaw_rmse_deg", "completeness")
    )
    return {
        "ate_mm": _root_mean_square(ate),
        "yaw_deg": _root_mean_square(yaw),
        "odometry_mm": _root_mean_square(odometry),
        "chamfer_mm": float(chamfer.mean()),
        "completeness": float(completeness.mean()),
        "within": {
            "ate_mm": int((ate <= LIMITS["ate_mm"]).sum()),
            "yaw_deg": int((yaw <= LIMITS["yaw_deg"]).sum()),
            "ratio": int((ate <= LIMITS["ratio"] * odometry).sum()),
            "chamfer_mm": int((chamfer <= LIMITS["chamfer_mm"]).sum()),
            "completeness": int((completeness >= LIMITS["completeness"]).sum()),
        },
        "measured": len(shaped),
    }


def _summary_line(f: Record) -> str:
    within = f["within"]
    return (
        f"All {f['measured']} together: ATE {f['ate_mm']:.1f} mm, {f['yaw_deg']:.2f}°, odometry "
        f"{f['odometry_mm']:.0f} mm (root mean squares), so that the ratio is "
        f"{f['ate_mm'] / f['odometry_mm']:.3f}; chamfer {f['chamfer_mm']:.1f} mm, completeness "
        f"{f['completeness']:.3f} (means). Within the limits are {within['ate_mm']} (ATE), "
        f"{within['yaw_deg']} (yaw), {within['ratio']} (ratio), {within['chamfer_mm']} (chamfer) "
        f"and {within['completeness']} (completeness)."
    )


def _root_mean_square(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _errors(some: list[Record]) -> dict[str, Any]:
    measured = [r for r in some if r.get("ate_rmse_m") is not None]
    ratio = [r["ate_rmse_m"] / r["ate_odometry_rmse_m"] for r in measured]
    shaped = [r for r in some if r.get("chamfer_m") is not None]
    return {
        "scans": len(some),
        "measured": len(measured),
        "ate_mm": _spread(1e3 * r["ate_rmse_m"] for r in measured),
        "yaw_deg": _spread(r["yaw_rmse_deg"] for r in measured),
        "odometry_mm": _spread(1e3 * r["ate_odometry_rmse_m"] for r in measured),
        "ratio": _spread(ratio),
        "chamfer_mm": _spread(1e3 * r["chamfer_m"] for r in shaped),
        "completeness": _spread((r["completeness"] for r in shaped), worst=min),
        "nees": _spread(r["nees_median"] for r in measured if r.get("nees_median") is not None),
        "reliable_mm": _spread(
            1e3 * r["worst_reliable_m"] for r in measured if r.get("worst_reliable_m") is not None
        ),
        "reliable_sigmas": _spread(
            r["worst_reliable_sigmas"]
            for r in measured
            if r.get("worst_reliable_sigmas") is not None
        ),
        "correct": sum(r["label"] == r.get("true_label") for r in some),
    }


def distances(found: list[Record]) -> tuple[str, Any]:
    """Distance driven by each planner, and distance from which on the answer did not change."""
    rows, figures = [], {}
    for name, some in _grouped(found, "planner").items():
        ended = [r for r in some if r.get("settled_m") is not None]
        confident = [r for r in some if r.get("confident")]
        f = figures[name] = {
            "scans": len(some),
            "settled_m": _spread(r["settled_m"] for r in ended),
            "driven_m": _spread(r["distance_m"] for r in ended),
            "correct": sum(map(_is_correct, some)),
            "confident": len(confident),
            "confident_correct": sum(map(_is_correct, confident)),
        }
        rows.append([
            name, classifier_of(some), str(f["scans"]),
            f"{f['settled_m']['median']:.1f} ({f['settled_m']['p95']:.1f})",
            f"{f['driven_m']['median']:.1f} ({f['driven_m']['p95']:.1f})",
            f"{f['correct']}/{f['scans']}", f"{f['confident_correct']}/{f['confident']}",
        ])  # fmt: skip
    head = [
        "planner", "classifier", "scans", "answer stands after [m]", "driven in all [m]", "correct",
        "correct of confident",
    ]  # fmt: skip
    return "Median (95th percentile).\n\n" + table(head, rows), figures


def answers(found: list[Record], data: Path) -> tuple[str, Any]:
    """Correct answers per class and start, agreement over starts, loss against complete clouds."""
    starts = sorted({r["start_deg"] for r in found})
    complete = complete_answers(found, data)
    groups = _grouped(found, "true_label")
    groups["all"] = found
    rows, figures = [], {}
    for name, some in groups.items():
        objects = _grouped(some, "object")
        same = [len({r["label"] for r in scans}) == 1 for scans in objects.values()]
        shares = [_correct([r for r in some if r["start_deg"] == start]) for start in starts]
        whole = np.mean([complete[key] == scans[0]["true_label"] for key, scans in objects.items()])
        figures[name] = {
            "objects": len(objects),
            "by_start": dict(zip(map(str, starts), shares, strict=True)),
            "correct": _correct(some),
            "same_from_all_starts": float(np.mean(same)),
            "complete_cloud": float(whole),
        }
        cells = [f"{share:.2f}" for share in shares]
        tail = [f"{_correct(some):.3f}", f"{np.mean(same):.2f}", f"{whole:.3f}"]
        rows.append([name.replace("_", " "), str(len(objects)), *cells, *tail])
    head = [
        "class", "objects", *(f"{start:.0f}°" for start in starts), "all starts",
        "same from all starts", "complete cloud",
    ]  # fmt: skip
    note = (
        "Share of correct answers by azimuth of the start; of complete clouds by the same "
        f"classifier, `{classifier_of(found)}`.\n\n"
    )
    return note + table(head, rows), figures


def times(found: list[Record]) -> tuple[str, Any]:
    """Median, 95th percentile and worst over the frames of all scans."""
    stages: dict[str, list[float]] = defaultdict(list)
    for record in found:
        for name, spent in record.get("stages", {}).items():
            stages[name] += spent
    figures: dict[str, Any] = {name: _spread(spent) for name, spent in stages.items()}
    rows = [[name, *(f"{f[which]:.1f}" for which in SPREAD)] for name, f in figures.items()]
    slow = [
        sum(t > MAX_FRAME_MS for t in record.get("stages", {}).get("frame", [])) for record in found
    ]
    figures["slow"] = {"frames": sum(slow), "scans": sum(count > 0 for count in slow)}
    return (
        f"{len(stages.get('frame', []))} frames of {len(found)} scans, one after the other; "
        f"{sum(slow)} of them, in {figures['slow']['scans']} scans, took more than "
        f"{MAX_FRAME_MS} ms.\n\n" + table(["stage", "median", "95 %", "worst"], rows),
        figures,
    )


def _spread(values: Iterable[float], worst: Callable[..., float] = max) -> dict[str, float]:
    known = list(values)
    if not known:
        return {"median": float("nan"), "p95": float("nan"), "worst": float("nan")}
    median, p95 = np.percentile(known, [50, 95])
    return {"median": float(median), "p95": float(p95), "worst": float(worst(known))}


def _marked(spread: dict[str, float], limit: str, digits: int = 1, sign: int = 1) -> str:
    """Median and worst value; bold if the worst misses its limit."""
    text = f"{spread['median']:.{digits}f} ({spread['worst']:.{digits}f})"
    return text if sign * spread["worst"] <= sign * LIMITS[limit] else f"**{text}**"


def _plain(spread: dict[str, float], digits: int) -> str:
    """Text of a figure without a limit; older records may lack it."""
    if np.isnan(spread["median"]):
        return "–"
    return f"{spread['median']:.{digits}f} ({spread['worst']:.0f})"


def _while_reliable(figures: dict[str, Any]) -> str:
    millimetres, sigmas = _plain(figures["reliable_mm"], 0), figures["reliable_sigmas"]
    if np.isnan(sigmas["median"]):
        return millimetres
    return f"{millimetres}; {sigmas['median']:.1f} ({sigmas['worst']:.1f}) σ"


def _is_correct(record: Record) -> bool:
    return record["label"] == record.get("true_label")


def _correct(some: list[Record]) -> float:
    return float(np.mean(list(map(_is_correct, some)))) if some else 0.0


def _grouped(found: list[Record], key: str) -> dict[str, list[Record]]:
    groups: dict[str, list[Record]] = defaultdict(list)
    for record in found:
        groups[str(record.get(key))].append(record)
    return dict(sorted(groups.items()))
