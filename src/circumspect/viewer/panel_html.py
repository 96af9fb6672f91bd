"""HTML of the panel's tables and bars; text from files is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from circumspect.classification.answer_text import answer_parts, percent, truth_text
from circumspect.recognition import FrameOutcome
from circumspect.viewer.colouring import CLASSES, ODOMETRY, PATH, TARGET

MOST_BARS, MOST_FAULTS = 5, 6
QUIET = "color:#64748b"


def answer_html(row: Mapping[str, Any], truth: str | None = None, message: str = "") -> str:
    """The answer in large letters, and the outcome of the frame.

    Args:
        row: See `DashboardState.row`.
        truth: The true class, if known.
        message: An additional line.
    """
    label, probability = row.get("label"), row.get("probability")
    if label is None or probability is None:
        head = f"<b style='font-size:1.5em'>no answer yet</b><br>{_text(row.get('outcome') or '')}"
    else:
        known = row.get("in_distribution") is not False
        name, figures = answer_parts(label, probability, known, row.get("alternatives"))
        head = (
            f"<b id='circumspect-label' style='font-size:1.7em'>{_text(name)}</b> "
            f"<span style='font-size:1.3em'>{_text(figures)}</span>"
        )
        if row.get("confident") is False:
            why = f": {_text(row['reason'])}" if row.get("reason") else ""
            head += f" <span style='{QUIET}'>not confident{why}</span>"
        if truth is not None:
            colour = "#15803d" if truth == label else "#b91c1c"
            judged = truth_text(label, known, truth)
            head += f" <span style='color:{colour if known else '#64748b'}'>{_text(judged)}</span>"
    frame, text = row.get("frame"), ""
    if frame is not None:
        text = (
            f"frame {frame + 1}, {row.get('stamp', 0.0):.1f} s · "
            f"{percent(row.get('coverage', 0.0))} coverage · {row.get('points', 0):,} points"
        )
    extra = f"<div>{_text(message)}</div>" if message else ""
    return _box(f"{head}<div style='{QUIET}'>{text}</div>{extra}")


def bars_html(probabilities: Mapping[str, float] | None) -> str:
    """A bar per class, the most probable first."""
    if not probabilities:
        return _box(f"<span style='{QUIET}'>probabilities appear with the first answer</span>")
    colours = {name: CLASSES[i % len(CLASSES)] for i, name in enumerate(probabilities)}
    first = sorted(probabilities.items(), key=lambda item: -item[1])[:MOST_BARS]
    rows = "".join(
        f"<tr><td style='padding-right:.6em;white-space:nowrap'>{_text(name)}</td>"
        f"<td style='width:60%'><div style='height:.75em;border-radius:2px;min-width:1px;"
        f"width:{100 * share:.1f}%;background:rgb({','.join(map(str, colours[name]))})'></div></td>"
        f"<td style='text-align:right'>{percent(share)}</td></tr>"
        for name, share in first
    )
    return _box(f"<table style='width:100%;border-spacing:0;line-height:1.25'>{rows}</table>")


def legend_html() -> str:
    """The legend of lines and frustum in the 3D view."""
    frustum = "<path d='M1 6 L12 1 V11 Z M12 1 L15 3 V9 L12 11' fill='none' stroke-width='1.5'/>"
    line = "<path d='M0 6 H16' stroke-width='3'/>"
    things = (
        (PATH, line, "path of the camera"),
        (ODOMETRY, line, "path by odometry alone"),
        (PATH, frustum, "camera, what it sees"),
        (TARGET, line, "next view, surface normal"),
    )
    cells = "".join(
        f"<div style='white-space:nowrap'><svg width='16' height='12' "
        f"stroke='rgb({','.join(map(str, colour))})'>{sign}</svg> {text}</div>"
        for colour, sign, text in things
    )
    style = "display:grid;grid-template-columns:1fr 1fr;gap:0 .8em;font-size:.9em"
    return _box(f"<div id='circumspect-legend' style='{style}'>{cells}</div>")


def times_html(row: Mapping[str, Any]) -> str:
    """The time per stage of the latest frame."""
    spent = row.get("milliseconds") or {}
    if not spent:
        return _box(f"<span style='{QUIET}'>no stage was run</span>")
    largest = max([*spent.values(), 1e-9])
    rows = "".join(
        f"<tr><td style='padding-right:.6em'>{_text(name)}</td><td style='width:55%'>"
        f"<div style='height:.6em;background:#94a3b8;width:{100 * ms / largest:.0f}%'></div></td>"
        f"<td style='text-align:right'>{ms:.1f} ms</td></tr>"
        for name, ms in [*spent.items(), ("all", sum(spent.values()))][:12]
        if name != "all"
    )
    total = f"<tr><td>all</td><td></td><td style='text-align:right'>{sum(spent.values()):.1f} ms"
    return _box(
        f"<table style='width:100%;border-spacing:0'>{rows}<b>{total}</b></td></tr></table>"
    )


def faults_html(rows: Sequence[Mapping[str, Any]], count: int) -> str:
    """The latest problems: unused frames and unreliable poses."""
    faults = list(_faults(rows, count))
    if not faults:
        return _box(f"<span style='{QUIET}'>no fault, all poses reliable</span>")
    lines = "".join(
        f"<li><b>frame {frame + 1}</b> {_text(what)}</li>" for frame, what in faults[:MOST_FAULTS]
    )
    more = f"<li style='{QUIET}'>…</li>" if len(faults) > MOST_FAULTS else ""
    return _box(f"<ul style='margin:0;padding-left:1.2em;color:#b91c1c'>{lines}{more}</ul>")


def _faults(rows: Sequence[Mapping[str, Any]], count: int) -> Iterable[tuple[int, str]]:
    """Problems, the latest first; one more than is shown."""
    found = 0
    for index in range(count - 1, -1, -1):
        row, reasons = rows[index], []
        if row.get("outcome") != FrameOutcome.CLASSIFIED:
            reasons.append(str(row.get("outcome")))
        if row.get("pose_reason"):
            reasons.append(str(row["pose_reason"]))
        if reasons:
            yield int(row.get("frame", index)), "; ".join(reasons)
            found += 1
            if found > MOST_FAULTS:
                return


def _box(content: str) -> str:
    return f"<div style='padding:.2em 1em;font-size:.85em'>{content}</div>"


def _text(value: Any) -> str:
    return escape(str(value)[:200])
