import re
import subprocess
import sys
from pathlib import Path

import pytest

from circumspect.furniture import make_furniture
from circumspect.geometry import write_ply

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.S)


@pytest.mark.parametrize("code", blocks("python"))
def test_python_snippets_run(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_ply("chair.ply", make_furniture("chair", 3).sampled(20_000, 0))
    exec(code, {})
    assert capsys.readouterr().out.startswith("chair ")


def test_short_with_one_picture_that_exists():
    assert len(README.splitlines()) < 120
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", README)
    assert len(pictures) == 1
    assert (ROOT / pictures[0]).is_file()


def test_no_placeholder_is_left():
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        assert not re.findall(r"^[A-Z]{4,}$", page.read_text(), re.M), page.name


def test_links_lead_somewhere():
    docs = ROOT / "docs"
    pages = [page for page in docs.rglob("*") if page.suffix in {".md", ".ipynb"}]
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *pages]:
        for link in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            if not link.startswith("http"):
                assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_the_benchmark_page_is_that_of_the_committed_results():
    words = [sys.executable, "-m", "benchmarks.page", "--check"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr or "run: python -m benchmarks.page"
