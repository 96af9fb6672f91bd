"""A live run is shown while it continues, and a hanging page does not delay it."""

from __future__ import annotations

import json
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")
pytest.importorskip("embreex", reason="the simulation is not installed")

from circumspect.classification import Classifier, Prediction
from circumspect.classification.evidence import cell_evidence
from circumspect.cli.commands.scan import Scan
from circumspect.exploration import ScanSettings
from circumspect.furniture import make_furniture
from circumspect.viewer import Dashboard, LiveWatch
from circumspect.viewer.why import Why

SHORT = Scan(
    object="chair-3", start=40.0, seed=5, driving=ScanSettings(frame_interval=2.0, max_frames=4)
)


@pytest.fixture(scope="module")
def dashboard():
    with Dashboard(Classifier.load("modelnet10"), port=0, always=True) as opened:
        yield opened


def run(dashboard):
    """A short scan with a watch; returns its result and the published moments."""
    parts = SHORT.prepared("scan")
    published = []
    dashboard.put = lambda make: (published.append(make), Dashboard.put(dashboard, make))
    watch = LiveWatch(parts.scan, dashboard, parts.room.scene, parts.ground_truth, "chair")
    return parts.scan.run((watch,)), published


def test_a_hanging_page_does_not_delay_a_run(dashboard):
    hanging, let_go = threading.Event(), threading.Event()

    def hang(shown):
        hanging.set()
        let_go.wait(60)

    show, dashboard.show = dashboard.show, hang
    try:
        result, _ = run(dashboard)
        assert len(result.steps) == 4
        assert hanging.wait(10)
        assert not let_go.is_set()
    finally:
        let_go.set()
        dashboard.show = show


def test_the_published_state_describes_the_run(dashboard):
    result, published = run(dashboard)
    assert len(published) == 5  # one a frame, and the end
    shown = published[-1]()
    assert shown.row["label"] == result.prediction.label
    assert shown.count == 4
    np.testing.assert_array_equal(
        shown.object_snapshot.points_xyz, result.last.model.cloud().points_xyz
    )
    assert shown.object_snapshot.frames_seen.max() == 4
    assert "the run is over" in shown.message
    assert len(shown.path_xyz) == len(shown.odometry_xyz) == 4
    assert len(shown.surroundings.meshes) >= 4
    assert shown.surroundings is published[0]().surroundings
    assert shown.target is not None or result.last.index < 2
    json.dumps(shown.row)


def test_the_answer_of_a_pause_is_published(dashboard):
    published = []
    parts = SHORT.prepared("scan")
    watch = LiveWatch(parts.scan, dashboard)
    dashboard.put = lambda make: published.append(make)
    watch.settled(Prediction.from_probabilities(("a", "b"), np.array([0.3, 0.7]), coverage=0.4))
    assert published == []  # no frame has come yet
    result = parts.scan.run((watch,))
    watch.settled(Prediction.from_probabilities(("a", "b"), np.array([0.3, 0.7]), coverage=0.4))
    shown = published[-1]()
    assert (shown.row["label"], shown.row["coverage"], shown.count) == ("b", 0.4, 4)
    assert published[-2]().rows[-1]["label"] == result.prediction.label


def wait_until_published(dashboard) -> None:
    """Wait until the thread of the publisher has shown all states."""
    end = time.monotonic() + 20
    while dashboard.publisher.slot._new and time.monotonic() < end:
        time.sleep(0.05)


def test_the_stage_shows_the_latest_moment(dashboard):
    _, published = run(dashboard)
    wait_until_published(dashboard)
    shown = published[-1]()
    dashboard.show(shown)
    assert dashboard.publisher.failure is None
    nodes = dashboard.stage._nodes
    assert len(nodes["/object"].points) == len(shown.object_snapshot.points_xyz)
    # Viser does not send changes that are too small to see.
    np.testing.assert_allclose(nodes["/camera"].position, shown.T_map_camera.translation, atol=1e-5)
    assert len(nodes["/grid/cells0"].vertices) == 8 * shown.object_snapshot.grid.occupied.sum()
    assert "/room/0" in nodes


def test_the_stage_removes_what_a_moment_lacks(dashboard):
    _, published = run(dashboard)
    wait_until_published(dashboard)
    shown = published[-1]()
    dashboard.show(shown)
    stage = dashboard.stage
    assert {"/camera", "/robot", "/grid/outline", "/target/stand"} <= stage._nodes.keys()
    bare = replace(
        shown,
        object_snapshot=replace(shown.object_snapshot, grid=None),
        T_map_camera=None,
        target=None,
    )
    stage.show(bare)
    left = {name for name in stage._nodes if not name.startswith("/room/")}
    assert left == {"/object", "/paths/registration", "/paths/odometry"}
    stage.show(shown)
    assert {"/camera", "/robot/0", "/grid/outline", "/target/stand"} <= stage._nodes.keys()


def explained(dashboard, shown):
    """Ask why, and wait for the answer."""
    dashboard.why.wanted = True
    dashboard.show(shown)
    end = time.monotonic() + 60
    while dashboard.why.found is None and time.monotonic() < end:
        time.sleep(0.05)
    assert dashboard.why.failure == ""


def test_every_colouring_gives_a_colour_a_point(dashboard):
    _, published = run(dashboard)
    shown = published[-1]()
    explained(dashboard, shown)
    dashboard.stage.explanation = dashboard.why.found
    pictures = set()
    for name in ("height", "frames that saw it", "surface normal", "class evidence"):
        dashboard.stage.colouring = name
        colours = dashboard.stage.colours(shown.object_snapshot)
        assert colours.shape == (len(shown.object_snapshot.points_xyz), 3)
        assert len(np.unique(colours, axis=0)) > 1
        pictures.add(colours.tobytes())
        dashboard.show(shown)
    assert len(pictures) == 4
    assert "nearest training objects" in dashboard.why.html()
    assert "speak for" in dashboard.why.html()


def test_evidence_of_one_run_is_not_shown_in_the_next(dashboard):
    _, published = run(dashboard)
    shown = published[-1]()
    assert published[0]().run is shown.run
    explained(dashboard, shown)
    dashboard.show(shown)
    assert dashboard.stage.explanation is not None
    dashboard.why.wanted = False
    _, published = run(dashboard)
    dashboard.show(published[0]())
    assert dashboard.stage.explanation is None
    assert "speak for" not in dashboard.why.html()


def test_evidence_found_after_its_run_is_dropped(monkeypatch):
    asked, go_on, changed = threading.Event(), threading.Event(), threading.Event()

    def slow(classifier, grid, metric):
        asked.set()
        go_on.wait(60)
        return cell_evidence(classifier, grid, metric=metric)

    monkeypatch.setattr("circumspect.viewer.why.cell_evidence", slow)
    classifier = Classifier.load()
    cloud = make_furniture("chair", 3).sampled(4000, 0)
    grid = classifier.input_spec.bounds(cloud).hits(cloud.points_xyz)
    why = Why(classifier, changed.set)
    try:
        why.wanted = True
        why.ask(grid, "first run")
        assert asked.wait(60)
        why.ask(None, "second run")
        go_on.set()
        assert changed.wait(60)
        assert why.found is None
        assert "asking" in why.html()
    finally:
        go_on.set()
        why.close()


def test_a_long_watch_thins_its_older_frames(dashboard, monkeypatch):
    monkeypatch.setattr("circumspect.viewer.live_watch.MOST_FRAMES", 2)
    _, published = run(dashboard)
    assert [make().count for make in published[:4]] == [1, 2, 2, 2]
    first, last = published[0](), published[3]()
    assert first.row["frame"] == 0
    assert last.row["frame"] == 3
