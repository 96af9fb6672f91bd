"""Export of a finished run as one HTML file that plays offline."""

from __future__ import annotations

import base64
import io
import json
import os
import re
from dataclasses import replace
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.storage import atomic_open
from circumspect.viewer.dashboard_state import DashboardState, ObjectSnapshot
from circumspect.viewer.guarded_server import guarded_server, stop
from circumspect.viewer.panel import images_side_by_side
from circumspect.viewer.panel_html import (
    answer_html,
    bars_html,
    faults_html,
    legend_html,
    times_html,
)
from circumspect.viewer.played_run import PlayedRun
from circumspect.viewer.probability_picture import probability_picture
from circumspect.viewer.stage import Stage

MOST_FRAMES = 300
"""Maximum number of frames; longer runs are subsampled evenly."""
MOST_POINTS = 6_000
"""Maximum number of the object's points, except in the last frame."""
FRAMES_PER_SECOND, LAST_SECONDS = 10.0, 4.0
STYLE = """
#circumspect{position:fixed;top:1em;right:1em;width:23em;max-height:calc(100% - 6em);overflow:auto;
background:#fff;border-radius:4px;box-shadow:0 0 1em rgba(0,0,0,.15);padding:.6em 0;z-index:2;
font-family:system-ui,sans-serif;font-size:14px;color:#0f172a}
#circumspect img{display:block;width:calc(100% - 2em);margin:.3em 1em}
#circumspect h1{font-size:1em;margin:0 1em .4em;font-weight:600;color:#64748b}
@media(max-width:46em){#circumspect{width:15em;font-size:11px}}
"""
SCRIPT = """
window.circumspectShow=function(n){
 var p=window.circumspectPanel[n];
 if(!p||n===window.circumspectAt)return;
 window.circumspectAt=n;
 ["answer","bars","faults","times"].forEach(function(k){
  document.getElementById("circumspect-"+k).innerHTML=p[k];});
 ["history","images"].forEach(function(k){
  var i=document.getElementById("circumspect-"+k);
  i.style.display=p[k]===null?"none":"block";
  if(p[k]!==null)i.src=window.circumspectPictures[p[k]];});
};
"""


def export_html(played: PlayedRun, path: str | os.PathLike[str]) -> int:
    """Write a run as an HTML file.

    Args:
        played: The run.
        path: The file.

    Returns:
        Size of the file [bytes].

    Raises:
        OutputError: The file cannot be written.
        MissingExtraError: viser is not installed.
    """
    # viser exports only the scene of a server; no browser connects to this one.
    server = guarded_server("127.0.0.1", 0)
    try:
        page = _page(played, server)
    finally:
        stop(server)
    with atomic_open(path) as stream:
        stream.write(page)
    return len(page.encode())


def chosen_frames(count: int) -> list[int]:
    """At most `MOST_FRAMES` frame numbers, including the first and the last."""
    return np.unique(np.linspace(0, count - 1, min(count, MOST_FRAMES)).astype(int)).tolist()


def _page(played: PlayedRun, server: Any) -> str:
    from viser._messages import RunJavascriptMessage

    stage, pictures = Stage(server), _Pictures()
    frames, panel = chosen_frames(len(played)), []
    stage.show(played.state_at(frames[-1]))
    serializer = server.get_scene_serializer()
    for number, frame in enumerate(frames):
        last = number == len(frames) - 1
        state = played.state_at(frame)
        stage.show(state if last else _thinned(state))
        panel.append(_panel_record(state, pictures, len(played)))
        serializer._insert_message(RunJavascriptMessage(f"window.circumspectShow({number})"))
        serializer.insert_sleep(LAST_SECONDS if last else 1 / FRAMES_PER_SECOND)
    page = serializer.as_html()
    return _with_panel(page, played, panel, pictures.files)


def _thinned(state: DashboardState) -> DashboardState:
    """The state with fewer points."""
    snapshot = state.object_snapshot
    every = -(-max(1, len(snapshot.points_xyz)) // MOST_POINTS)
    fewer = ObjectSnapshot(
        snapshot.points_xyz[::every], snapshot.normals_xyz[::every], snapshot.frames_seen[::every],
        snapshot.grid,
    )  # fmt: skip
    return replace(state, object_snapshot=fewer)


def _panel_record(state: DashboardState, pictures: _Pictures, total: int) -> dict[str, Any]:
    """The contents of the panel as JSON types."""
    row = state.row
    images, seen = state.images, None
    if images is not None:
        seen = pictures.of(images.frame, images_side_by_side(images))
    return {
        "answer": answer_html(row, state.truth, state.message),
        "bars": bars_html(row.get("probabilities")),
        "faults": faults_html(state.rows, state.count),
        "times": times_html(row),
        "history": pictures.add(probability_picture(state.rows, state.count, total), "PNG"),
        "images": seen,
    }


class _Pictures:
    """Pictures as data URLs without duplicates."""

    def __init__(self) -> None:
        self.files: list[str] = []
        self._frames: dict[int, int] = {}

    def add(self, pixels: NDArray[np.uint8], kind: str) -> int:
        from PIL import Image

        packed = io.BytesIO()
        picture = Image.fromarray(pixels)
        if kind == "PNG":
            # A palette makes pictures with few flat colours small.
            picture.quantize(64).save(packed, kind, optimize=True)
        else:
            picture.save(packed, kind, quality=75)
        text = base64.b64encode(packed.getvalue()).decode("ascii")
        self.files.append(f"data:image/{kind.lower()};base64,{text}")
        return len(self.files) - 1

    def of(self, frame: int, pixels: NDArray[np.uint8]) -> int:
        if frame not in self._frames:
            self._frames[frame] = self.add(pixels, "JPEG")
        return self._frames[frame]


def _with_panel(
    page: str, played: PlayedRun, panel: list[dict[str, Any]], pictures: list[str]
) -> str:
    name = escape(str(played.run.config.get("object", played.run.path.name))[:100])
    parts = "".join(
        f"<img id='circumspect-{part}' alt=''>" if part in ("history", "images")
        else f"<div id='circumspect-{part}'></div>"
        for part in ("answer", "bars", "history", "images", "faults", "times")
    )  # fmt: skip
    data = (
        f"window.circumspectPanel={_inline(panel)};window.circumspectPictures={_inline(pictures)};"
    )
    head = f"<style>{STYLE}</style>"
    body = (
        f"<div id='circumspect'><h1>circumspect: {name}</h1>{parts}{legend_html()}</div>"
        f"<script>{data}{SCRIPT}window.circumspectShow(0)</script>"
    )
    at = page.rindex("</body>")
    page = page[:at] + body + page[at:]
    page = re.sub(
        "<title>.*?</title>", lambda _: f"<title>circumspect: {name}</title>", page, count=1
    )
    at = page.index("</head>")
    return page[:at] + head + page[at:]


def _inline(value: Any) -> str:
    """JSON that is safe within a script element."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")
