"""The version has one source, `circumspect.__version__`; all metadata are the same everywhere."""

from __future__ import annotations

import re
import tomllib
from importlib import metadata
from pathlib import Path
from xml.etree import ElementTree

import circumspect

ROOT = Path(__file__).resolve().parents[2]


def test_the_build_reads_the_version_from_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert "version" not in project["project"]
    (source,) = project["tool"]["dynamic-metadata"]
    assert (source["field"], source["input"]) == ("version", "src/circumspect/__init__.py")


def test_the_installed_package_has_this_version() -> None:
    assert metadata.version("circumspect") == circumspect.__version__


def test_other_files_repeat_the_version() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    manifest = ElementTree.parse(ROOT / "ros2" / "circumspect_ros" / "package.xml")
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"\nversion: {circumspect.__version__}\n" in citation
    assert manifest.findtext("version") == circumspect.__version__
    assert re.search(rf"^## \[.*{re.escape(circumspect.__version__)}", changes, re.MULTILINE)


def test_authors_and_license_are_the_same_in_all_metadata() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (author,) = project["authors"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    manifest = ElementTree.parse(ROOT / "ros2" / "circumspect_ros" / "package.xml")
    assert f"\nauthors:\n  - name: {author['name']}\n" in citation
    assert f"\nlicense: {project['license']}\n" in citation
    assert manifest.findtext("author") == manifest.findtext("maintainer") == author["name"]
    assert manifest.findtext("license") == project["license"]


def test_addresses_are_the_same_in_all_metadata() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    manifest = ElementTree.parse(ROOT / "ros2" / "circumspect_ros" / "package.xml")
    urls = {url.text for url in manifest.iter("url")}
    assert urls <= set(project.get("urls", {}).values())
    assert bool(urls) == bool(project.get("urls"))


def test_each_tested_python_is_named_alike() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    said = {line.rsplit(" ", 1)[1] for line in project["project"]["classifiers"] if "3." in line}
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    matrix = re.search(r"python: \[(.*)\]", workflow)
    assert matrix is not None
    assert set(re.findall(r"3\.\d+", matrix.group(1))) == said
    built = {f"3.{one[3:5]}" for one in project["tool"]["cibuildwheel"]["build"]}
    assert built == said
