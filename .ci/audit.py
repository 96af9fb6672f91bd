"""Known faults of the packages that constraints.txt pins and of those that are installed.

    python .ci/audit.py

First, without a network, against .ci/refused.txt: a release named there fails the audit. Then
with pip-audit against the advisories of the package index. Where those can not be reached, which
is so behind mirrors that hold packages alone, the audit says so and does not fail for it.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import distributions
from pathlib import Path

from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

HERE = Path(__file__).resolve().parent
REFUSED, PINS = HERE / "refused.txt", HERE.parent / "constraints.txt"
PATIENCE = 300
"""For pip-audit [s]."""


@dataclass(frozen=True)
class Refusal:
    """Releases of a package that are not installed, and why."""

    name: str
    versions: tuple[SpecifierSet, ...]
    reason: str

    def applies(self, name: str, version: str) -> bool:
        """Whether a release is one of them."""
        return canonicalize_name(name) == self.name and any(
            known.contains(version, prereleases=True) for known in self.versions
        )


def refusals(text: str) -> list[Refusal]:
    """The list's lines: name, versions parted by commas of which any applies, reason."""
    found = []
    for line in text.splitlines():
        if line.strip() and not line.startswith("#"):
            name, versions, reason = line.split(maxsplit=2)
            each = tuple(SpecifierSet(version) for version in versions.split(","))
            found.append(Refusal(canonicalize_name(name), each, reason))
    return found


def pinned(text: str) -> dict[str, str]:
    """Name to version."""
    lines = [line.split("#")[0].strip() for line in text.splitlines()]
    return dict(line.split("==", 1) for line in lines if "==" in line)


def installed() -> dict[str, str]:
    """Name to version, of this environment."""
    return {found.metadata["Name"]: found.version for found in distributions()}


def refused(releases: Mapping[str, str], known: Iterable[Refusal]) -> list[str]:
    """A line for each release that is refused."""
    listed = list(known)
    return [
        f"{name} {version} is refused: {refusal.reason}"
        for name, version in sorted(releases.items())
        for refusal in listed
        if refusal.applies(name, version)
    ]


def advisories(run: Callable[[], subprocess.CompletedProcess[str]]) -> tuple[int, str]:
    """What pip-audit says.

    Returns:
        How many releases are known to be faulty, and a line that tells how it went.
    """
    try:
        done = run()
        report = json.loads(done.stdout)["dependencies"]
    except (OSError, subprocess.SubprocessError, ValueError, KeyError):
        return 0, "NOT AUDITED against advisories: pip-audit or its data base can not be reached"
    audited = [entry for entry in report if "vulns" in entry]
    if not audited:
        return 0, "NOT AUDITED against advisories: this package index does not hold any"
    faulty = [
        f"{entry['name']} {entry['version']}: {', '.join(v['id'] for v in entry['vulns'])}"
        for entry in audited
        if entry["vulns"]
    ]
    left = len(report) - len(audited)
    told = f"{len(audited)} releases audited against advisories, {left} not known there"
    return len(faulty), "\n".join([told, *faulty])


def pip_audit() -> subprocess.CompletedProcess[str]:
    """Audit the pins, without installing anything."""
    words = ["--requirement", str(PINS), "--no-deps", "--disable-pip", "--format", "json"]
    return subprocess.run(
        [sys.executable, "-m", "pip_audit", *words, "--progress-spinner", "off", "--timeout", "15"],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


def main() -> int:
    """Audit; 1 where something known to be bad is pinned or installed."""
    known = refusals(REFUSED.read_text(encoding="utf-8"))
    releases = {**installed(), **pinned(PINS.read_text(encoding="utf-8"))}
    bad = refused(installed(), known) + refused(releases, known)
    for line in dict.fromkeys(bad):
        print(line)
    print(f"{len(releases)} releases, {len(dict.fromkeys(bad))} of them refused by .ci/refused.txt")
    faulty, told = advisories(pip_audit)
    print(told)
    return 1 if bad or faulty else 0


if __name__ == "__main__":
    sys.exit(main())
