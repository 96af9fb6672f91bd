"""The looping animation that opens the README: `python docs/animation.py`.

A simulated robot scans a piece of furniture; a picture now and then shows what the camera
sees, the plan view with the growing model, and the answer so far.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from circumspect.classification import Classifier
from circumspect.classification.answer_text import percent
from circumspect.exploration.object_scan import ObjectScan
from circumspect.exploration.scan_settings import RoomSettings, ScanSettings
from circumspect.exploration.simulated_scan import SimulatedScan
from circumspect.gathering.scanned_object import scanned_object
from circumspect.planning import SurfaceNormalPlanner
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.runs.plan_panel import draw_plan
from circumspect.runs.run_path_log import RunPathLog
from circumspect.sensing import DepthNoise, RgbdFrame
from circumspect.simulation import GroundTruthRecorder, RobotSettings, SimulatedRobot, outlines
from circumspect.storage import atomic_path

SIZE = (960, 344)
"""Of the animation [px]."""
COLOURS = 192
"""Of the palette; fewer make the file smaller."""
MILLISECONDS, LAST_MILLISECONDS = 110, 2500
"""How long a picture stays, and the last one."""
TINT = np.array([234, 88, 12])
BAR, LEADING_BAR = "0.82", "#1d4ed8"


class Film:
    """Draws every n-th step of a scan; a `PipelineObserver`."""

    def __init__(
        self, scan: ObjectScan, log: RunPathLog, limits: tuple[float, ...], every: int
    ) -> None:
        self.pictures: list[Image.Image] = []
        self._scan, self._log, self._limits, self._every = scan, log, limits, every
        self._steps: list[RecognitionStep] = []

    def on_step(self, step: RecognitionStep) -> None:
        self._steps.append(step)
        if step.index % self._every == 0 and step.grid is not None:
            self._draw()

    def on_end(self, result: RecognitionResult) -> None:
        self._steps = list(result.steps)
        self._draw()

    def _draw(self) -> None:
        frame, result = self._scan.frame, RecognitionResult(tuple(self._steps))
        if frame is None or result.last is None or result.last.grid is None:
            return
        figure = Figure(figsize=(SIZE[0] / 100, SIZE[1] / 100), dpi=100, facecolor="white")
        FigureCanvasAgg(figure)
        view = figure.add_axes((0.008, 0.06, 0.40, 0.83))
        view.imshow(seen(frame, self._scan))
        view.set_axis_off()
        view.set_title("what the camera sees (object tinted)", fontsize=10, color="0.3")
        self._draw_plan(figure, result)
        draw_answer(figure, result.last, self._scan.driven_m)
        figure.canvas.draw()
        self.pictures.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3]))

    def _draw_plan(self, figure: Figure, result: RecognitionResult) -> None:
        assert result.last is not None
        plan = figure.add_axes((0.425, 0.06, 0.298, 0.83))
        cloud = result.last.model.cloud().thinned(40_000)
        draw_plan(plan, cloud, result, self._log.run_path(result))
        legend = plan.get_legend()
        if legend is not None:
            legend.remove()
        for bar in plan.child_axes:
            bar.remove()
        left, right, low, high = self._limits
        plan.set(xlim=(left, right), ylim=(low, high), xlabel="", ylabel="", xticks=[], yticks=[])
        for text in plan.texts:
            text.set_clip_on(True)
        plan.set_title("", loc="left")
        plan.set_title("its way (dashed: wheels alone) and model", fontsize=10, color="0.3")


def seen(frame: RgbdFrame, scan: ObjectScan) -> NDArray[np.uint8]:
    """The colour image with the object tinted."""
    assert frame.colour is not None
    colour = frame.colour.astype(np.float64)
    believed = frame.at(scan.T_map_base.as_transform() * scan.robot.T_base_camera)
    mask = scan.pipeline.segmentation.object_mask(believed, scan.pipeline.model.points_xyz)
    colour[mask] = 0.55 * colour[mask] + 0.45 * TINT
    return colour.astype(np.uint8)


def draw_answer(figure: Figure, step: RecognitionStep, driven_m: float) -> None:
    """Bars of all classes, and the answer in words."""
    assert step.prediction is not None
    axes = figure.add_axes((0.82, 0.06, 0.165, 0.73))
    named = step.prediction.probabilities
    places = np.arange(len(named))[::-1]
    colours = [LEADING_BAR if name == step.prediction.label else BAR for name in named]
    axes.barh(places, list(named.values()), color=colours, height=0.72)
    axes.set_yticks(places, [name.replace("_", " ") for name in named], fontsize=9)
    axes.set(xlim=(0, 1), xticks=[])
    axes.tick_params(length=0)
    axes.spines[["top", "right", "bottom"]].set_visible(False)
    words = f"{step.prediction.label.replace('_', ' ')}  {percent(step.prediction.probability)}"
    figure.text(0.985, 0.885, words, fontsize=15, fontweight="bold", ha="right", color=LEADING_BAR)
    figure.text(
        0.985, 0.825, f"after {driven_m:.1f} m, {percent(step.coverage)} coverage", fontsize=9.5,
        ha="right", color="0.35",
    )  # fmt: skip


def filmed(name: str, start_deg: float, seed: int, every: int) -> list[Image.Image]:
    """Scan an object and draw it."""
    thing = scanned_object(name, 0)
    config: dict[str, Any] = {"object": thing.name, "seed": seed, "start_deg": start_deg}
    driving = ScanSettings(frame_interval=1.0)
    planner = SurfaceNormalPlanner()
    parts = SimulatedScan.prepared(
        thing.mesh, RoomSettings(), driving, planner, Classifier.load(), config
    )
    start = parts.room.start(start_deg)
    robot = GroundTruthRecorder(
        SimulatedRobot(
            parts.room.scene, start, parts.room.mount, RobotSettings(slip=0.05), parts.camera,
            DepthNoise(), seed, colour=True,
        )
    )  # fmt: skip
    scan = ObjectScan(robot, parts.pipeline, planner, driving)
    log = RunPathLog(scan, None, lambda: robot.trajectory, outlines(parts.room.scene))
    # The robot's map begins at its start, which is known here; so the plan need not move.
    middle = start.inverse().applied(np.array(parts.room.orbit.centre_xy))
    half = parts.room.orbit.radius + 0.6
    x, y = (float(value) for value in middle)
    film = Film(scan, log, (x - half, x + half, y - half, y + half), every)
    scan.run((log, film))
    return film.pictures


def save(pictures: list[Image.Image], path: Path) -> None:
    """Write a looping GIF with one palette for all pictures."""
    some = pictures[:: max(1, len(pictures) // 6)]
    sheet = Image.new("RGB", (SIZE[0], SIZE[1] * len(some)))
    for number, picture in enumerate(some):
        sheet.paste(picture, (0, number * SIZE[1]))
    palette = sheet.quantize(COLOURS, method=Image.Quantize.MEDIANCUT)
    values = np.array(palette.getpalette(), np.uint8).reshape(-1, 3)
    values[(values > 244).all(axis=1)] = 255  # The paper is white, not nearly so.
    palette.putpalette(values.tobytes())
    flat = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    times = [MILLISECONDS] * (len(flat) - 1) + [LAST_MILLISECONDS]
    with atomic_path(path) as aside:
        flat[0].save(
            aside, format="GIF", save_all=True, append_images=flat[1:], duration=times, loop=0,
            optimize=True,
        )  # fmt: skip


def main() -> int:
    """Scan, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--object", default="chair-3")
    parser.add_argument("--start", type=float, default=135.0)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--every", type=int, default=3, help="draw each n-th frame")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "demo.gif")
    arguments = parser.parse_args()
    pictures = filmed(arguments.object, arguments.start, arguments.seed, arguments.every)
    save(pictures, arguments.out)
    megabytes = arguments.out.stat().st_size / 1e6
    print(f"{arguments.out}: {len(pictures)} pictures, {megabytes:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
