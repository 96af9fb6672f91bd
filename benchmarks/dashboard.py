"""Update rate of the dashboard for a large object.

    python -m benchmarks.dashboard

An object of 200,000 points changes at every update. Positions, colours, grid, camera, paths and
panel are created and sent. A client on the same machine receives everything and draws nothing. With
--browser, the client is Chromium, which draws in software if the machine has no graphics processor.
"""

from __future__ import annotations

import argparse
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import viser
from scipy.spatial.transform import RigidTransform, Rotation
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from benchmarks.report import Row, write_report
from circumspect.classification import Classifier
from circumspect.geometry import PinholeCamera, PointCloud
from circumspect.viewer.dashboard import Dashboard
from circumspect.viewer.dashboard_state import DashboardState, FrameImages, ObjectSnapshot

POINTS, UPDATES, FRAMES = 200_000, 100, 300
TARGET_RATE = 20.0
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)  # fmt: skip


def dashboard_states(classifier: Classifier) -> Callable[[int], DashboardState]:
    """States of a run whose object differs at each update."""
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(POINTS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    probabilities = dict.fromkeys("abcdefghij", 0.1)
    rows = [
        {
            "frame": i, "stamp": 0.5 * i, "outcome": "classified", "label": "a", "gate": "open",
            "probability": 0.1, "probabilities": probabilities, "coverage": i / FRAMES,
            "points": POINTS, "milliseconds": {"register": 30.0, "fuse": 10.0, "classify": 5.0},
        }
        for i in range(FRAMES)
    ]  # fmt: skip
    depth = rng.uniform(0.5, 4.0, (480, 640)).astype(np.float32)
    colour = rng.integers(0, 256, (480, 640, 3)).astype(np.uint8)
    azimuths = np.linspace(0, 2 * np.pi, FRAMES)
    path = 1.5 * np.column_stack([np.cos(azimuths), np.sin(azimuths), np.ones(FRAMES)])

    def state(number: int) -> DashboardState:
        index = number % FRAMES
        # The object differs each time, so nothing can be reused from the previous update.
        points = directions * (0.5 + 0.05 * np.sin(7 * directions[:, :1] + 0.1 * number))
        grid = classifier.input_spec.bounds(PointCloud(points)).hits(points)
        seen = rng.integers(1, 50, POINTS)
        return DashboardState(
            rows, index + 1, ObjectSnapshot(points, directions, seen, grid),
            FrameImages(depth, colour, number), PinholeCamera.xtion(),
            RigidTransform.from_components(path[index], Rotation.identity()),
            RigidTransform.from_translation([0.0, 0.2, 1.2]), path[: index + 1], path[: index + 1],
        )  # fmt: skip

    return state


@contextmanager
def receiving_client(dashboard: Dashboard) -> Iterator[list[int]]:
    """A client that receives everything; yields the sizes of the messages [bytes]."""
    received: list[int] = []
    protocol = [Subprotocol(f"viser-v{viser.__version__}")]
    url = dashboard.url.replace("http", "ws")
    with connect(url, subprotocols=protocol, proxy=None, max_size=None) as channel:

        def read() -> None:
            try:
                for message in channel:
                    received.append(len(message))
            except ConnectionClosed:
                return

        threading.Thread(target=read, daemon=True).start()
        yield received


@contextmanager
def browser(dashboard: Dashboard) -> Iterator[list[int]]:
    """Chromium with the page open."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        page = started.new_page()
        page.goto(dashboard.url)
        while not dashboard.watched:
            time.sleep(0.05)
        yield []
        started.close()


def measured(dashboard: Dashboard, made: list[DashboardState], what: str) -> Row:
    """Time from update to update, as fast as the page's thread takes them."""
    for state in made[:3]:
        dashboard.show(state)
    times = []
    for number in range(UPDATES):
        began = time.perf_counter()
        dashboard.show(made[number % len(made)])
        dashboard.server.flush()
        times.append(1e3 * (time.perf_counter() - began))
    median, p95 = np.percentile(times, [50, 95])
    return Row(what, float(median), float(p95), min(times), UPDATES)


def main() -> None:
    """Measure and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--browser", action="store_true", help="use Chromium as the client")
    arguments = parser.parse_args()
    classifier = Classifier.load()
    state = dashboard_states(classifier)
    made = [state(number) for number in range(8)]
    client = browser if arguments.browser else receiving_client
    with Dashboard(classifier, port=0, always=True) as dashboard, client(dashboard) as received:
        began, before = time.perf_counter(), sum(received)
        row = measured(dashboard, made, f"update of {POINTS:,} points")
        spent = time.perf_counter() - began
        time.sleep(1.0)
        got = sum(received) - before
    rate = 1e3 / row.median
    verdict = "reached" if rate >= TARGET_RATE else "not reached"
    notes = f"{rate:.0f} updates per second; the target of {TARGET_RATE:g} is {verdict}."
    if not arguments.browser:
        notes += f" {got / 1e6 / spent:.0f} MB/s were received."
    command = "python -m benchmarks.dashboard" + (" --browser" if arguments.browser else "")
    name = "dashboard_browser" if arguments.browser else "dashboard"
    write_report(name, command, [row], notes)


if __name__ == "__main__":
    main()
