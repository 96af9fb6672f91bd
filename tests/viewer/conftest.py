"""A short run on disk, and a browser where there is one."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from circumspect.cli.commands.scan import Scan
from circumspect.exploration import ScanSettings

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--no-first-run", "--use-gl=angle",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
)  # fmt: skip
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="session")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scan of a chair, six frames long, as `circumspect scan` leaves it."""
    pytest.importorskip("embreex", reason="the simulation is not installed")
    out = tmp_path_factory.mktemp("runs") / "chair"
    scan = Scan(
        object="chair-3",
        start=40.0,
        seed=5,
        driving=ScanSettings(frame_interval=2.0, max_frames=6),
        out=out,
        json=True,
    )
    assert scan.run() == 0
    return out


@pytest.fixture
def copied_run(finished_run: Path, tmp_path: Path) -> Path:
    """A copy of the run that a test may damage."""
    return Path(shutil.copytree(finished_run, tmp_path / "run"))


@pytest.fixture(scope="session")
def browser() -> Iterator[object]:
    """Headless Chromium, drawing in software."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if path is None:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} is installed")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=path, args=list(FLAGS))
        yield started
        started.close()
