"""The documentation builds, warnings being errors, and needs no network to be read."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import circumspect

pytestmark = pytest.mark.xdist_group("site")  # It is built once.
ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WIDTHS = (1280, 400)
"""Of a laptop's window and of a phone [px]."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("sphinx", reason='needs pip install "circumspect[docs]"')
    folder = tmp_path_factory.mktemp("site")
    words = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d"]
    words += [str(folder / "doctrees"), str(DOCS), str(folder / "html")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr
    return folder / "html"


def test_every_page_is_there_and_can_be_reached(site):
    first = (site / "index.html").read_text()
    folders = ("*.md", "models/*.md", "development/*.md", "notebooks/*.ipynb")
    for page in (page for folder in folders for page in DOCS.glob(folder)):
        place = page.relative_to(DOCS).with_suffix(".html").as_posix()
        assert (site / place).is_file()
        assert page.stem == "index" or f'href="{place}"' in first, page.name


def test_nothing_is_fetched_from_elsewhere(site):
    fetched = r'<(?:script|img|iframe)[^>]* src="(?:https?:)?//|<link[^>]* href="(?:https?:)?//'
    for page in site.rglob("*.html"):
        assert not re.search(fetched, page.read_text()), page.name
    for sheet in site.rglob("*.css"):
        assert not re.search(r"(?:@import|url\()\s*['\"]?(?:https?:)?//", sheet.read_text())


def test_the_api_is_described_and_refers_to_itself(site):
    page = (site / "api" / "recognition.html").read_text()
    assert 'id="circumspect.recognition.RecognitionPipeline.step"' in page
    # Types of arguments, and names in back-ticks, lead to where they are described.
    assert 'href="sensing.html#circumspect.sensing.Segmentation"' in page
    assert 'href="#circumspect.recognition.PipelineObserver"' in page
    assert "system-message" not in "".join(p.read_text() for p in site.rglob("*.html"))


def test_command_line_page_has_the_help_of_every_command(site):
    from circumspect.cli.main import COMMANDS

    page, text = (site / "cli.html").read_text(), (DOCS / "cli.md").read_text()
    for command in COMMANDS:
        assert f"usage: circumspect {command} [-h]" in page
        assert f"`{command}`" in text


def test_data_flow_picture_is_that_of_its_script(tmp_path):
    words = [sys.executable, str(DOCS / "data_flow.py"), "--out", str(tmp_path / "data-flow.svg")]
    subprocess.run(words, check=True, timeout=60)
    drawn = (tmp_path / "data-flow.svg").read_text()
    assert drawn == (DOCS / "data-flow.svg").read_text(), "run: python docs/data_flow.py"


def test_no_page_is_wider_than_the_screen(site):
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.skip("no Chromium")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        wide = []
        for width in WIDTHS:
            view = browser.new_page(viewport={"width": width, "height": 800})
            for page in sorted(site.rglob("*.html")):
                view.goto(page.as_uri(), wait_until="load")
                if view.evaluate("document.documentElement.scrollWidth") > width:
                    wide.append(f"{page.relative_to(site)} at {width} px")
        browser.close()
    assert wide == []


def test_the_api_page_names_all_that_the_package_gives():
    text = (DOCS / "api" / "index.md").read_text()
    listed = re.findall(r"^   circumspect\.(\w+)\.(\w+)$", text, re.M)
    assert sorted(name for _, name in listed) == sorted(circumspect.__all__)
    for home, name in listed:
        assert getattr(circumspect, name).__module__.startswith(f"circumspect.{home}")


def test_every_package_has_its_api_page():
    packages = {file.parent.name for file in (ROOT / "src" / "circumspect").glob("*/__init__.py")}
    # The command line is described by its own help.
    assert packages - {"cli"} <= {page.stem for page in (DOCS / "api").glob("*.md")}
