"""The audit of dependencies: it finds what is listed, and says when it could not look."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def audit():
    spec = importlib.util.spec_from_file_location("audit", ROOT / ".ci" / "audit.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["audit"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["audit"]


def finished(report) -> subprocess.CompletedProcess[str]:
    text = report if isinstance(report, str) else json.dumps({"dependencies": report})
    return subprocess.CompletedProcess([], 0, text, "")


def test_pinned_and_installed_releases_are_not_refused(audit):
    known = audit.refusals(audit.REFUSED.read_text())
    pins = audit.pinned(audit.PINS.read_text())
    assert len(pins) > 50
    assert audit.refused(pins, known) == []
    assert audit.refused(audit.installed(), known) == []


@pytest.mark.parametrize(
    ("name", "version", "bad"),
    [
        ("lightning", "2.6.2", True),
        ("Lightning", "2.6.3", True),
        ("pytorch_lightning", "2.6.3", True),
        ("lightning", "2.6.4", False),
        ("torch", "2.5.1+cpu", True),
        ("torch", "2.11.0", False),
    ],
)
def test_releases_are_matched_by_name_and_version(audit, name, version, bad):
    known = audit.refusals(audit.REFUSED.read_text())
    lines = audit.refused({name: version}, known)
    assert bool(lines) is bad
    if bad:
        assert lines[0].startswith(f"{name} {version} is refused: ")
        assert "https://" in lines[0]


def test_lower_bounds_of_the_package_leave_no_refused_release(audit):
    import tomllib

    from packaging.requirements import Requirement

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    lowest = {}
    for words in (word for group in groups for word in group if not word.startswith("circumspect")):
        requirement = Requirement(words)
        for bound in requirement.specifier:
            if bound.operator == ">=":
                lowest[requirement.name] = bound.version
    assert "torch" in lowest
    assert audit.refused(lowest, audit.refusals(audit.REFUSED.read_text())) == []


def test_advisories_are_counted(audit):
    report = [
        {"name": "a", "version": "1", "vulns": [{"id": "X-1"}, {"id": "X-2"}]},
        {"name": "b", "version": "2", "vulns": []},
        {"name": "c", "version": "3", "skip_reason": "not found"},
    ]
    faulty, line = audit.advisories(lambda: finished(report))
    assert faulty == 1
    assert line == "2 releases audited against advisories, 1 not known there\na 1: X-1, X-2"


def unreachable():
    raise subprocess.TimeoutExpired("pip-audit", 1)


@pytest.mark.parametrize(
    "run",
    [
        unreachable,
        lambda: finished("Traceback …"),
        lambda: finished([{"name": "a", "version": "1", "skip_reason": "not found"}]),
    ],
)
def test_a_failed_audit_is_reported_and_does_not_fail(audit, run):
    faulty, line = audit.advisories(run)
    assert faulty == 0
    assert line.startswith("NOT AUDITED")
