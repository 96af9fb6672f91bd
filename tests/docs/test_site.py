"""The documentation builds, warnings being errors, and needs no network to be read."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import circumspect

pytestmark = pytest.mark.xdist_group("site")  # It is built once.
ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("sphinx", reason='needs pip install "circumspect[docs]"')
    folder = tmp_path_factory.mktemp("site")
    words = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d"]
    words += [str(folder / "doctrees"), str(DOCS), str(folder / "html")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return folder / "html"


def test_every_page_is_there_and_can_be_reached(site):
    first = (site / "index.html").read_text()
    for page in (*DOCS.glob("*.md"), *DOCS.glob("models/*.md"), *DOCS.glob("development/*.md")):
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
