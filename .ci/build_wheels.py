"""The sdist, and a wheel for each interpreter, in dist/.

    python .ci/build_wheels.py python3.11 python3.12

Interpreters are names or paths; those that are not installed are skipped with a line. Wheels are
built from the sdist. From CPython 3.12 on a single wheel serves all versions. The wheels get the
manylinux tag of the oldest C library that they run with (auditwheel). Where the cross compiler
aarch64-linux-gnu-g++ is installed, each wheel is built for aarch64 too.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DIST, WORK = ROOT / "dist", ROOT / "build" / "wheels"
STABLE = (3, 12)
"""From this version on a wheel keeps to CPython's stable ABI."""
CROSS = "aarch64-linux-gnu"
TAG_OF = "import sys, sysconfig; print(*sys.version_info[:2], sysconfig.get_path('include'))"


def run(*command: str | Path, environment: Mapping[str, str] | None = None) -> str:
    """Run a command in the repository; its output is returned, its errors are shown."""
    words = [str(word) for word in command]
    print("+", " ".join(words), file=sys.stderr, flush=True)
    own = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    done = subprocess.run(
        words, cwd=ROOT, env={**own, **(environment or {})}, stdout=subprocess.PIPE, text=True
    )
    if done.returncode:
        sys.stderr.write(done.stdout)
        raise SystemExit(f"failed with {done.returncode}: {' '.join(words)}")
    return done.stdout


def chosen(interpreters: list[str]) -> dict[str, tuple[tuple[int, int], str]]:
    """Interpreters that a wheel is built with: path to version and folder of its headers."""
    found: dict[str, tuple[tuple[int, int], str]] = {}
    for name in interpreters:
        path = shutil.which(name)
        asked = path and subprocess.run([path, "-c", TAG_OF], capture_output=True, text=True)
        if not path or not asked or asked.returncode:
            print(f"{name} is not installed; skipped")
            continue
        major, minor, include = asked.stdout.split(maxsplit=2)
        version = int(major), int(minor)
        if version >= STABLE and any(known >= STABLE for known, _ in found.values()):
            print(f"{name} takes the wheel of the other one from 3.12 on")
            continue
        found[path] = version, include.strip()
    return found


def sdist() -> Path:
    """Build the sdist; its path."""
    run(sys.executable, "-m", "build", "--sdist", "--outdir", DIST)
    return next(DIST.glob("*.tar.gz"))


def wheel(
    source: Path, python: str, name: str, environment: Mapping[str, str] | None = None
) -> None:
    """Build a wheel from the sdist, and put it with its manylinux tag into dist/."""
    venv, raw = WORK / "environment", WORK / name
    run(python, "-m", "venv", "--clear", venv)
    run(
        venv / "bin" / "python", "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", raw,
        source, environment=environment,
    )  # fmt: skip
    made = next(raw.glob("*.whl"))
    run(sys.executable, "-m", "auditwheel", "repair", "--wheel-dir", DIST, made)


def cross_environment(version: tuple[int, int], include: str) -> dict[str, str]:
    """What has pip build for aarch64: compiler, headers and names of the other processor."""
    suffix = ".abi3.so" if version >= STABLE else f".cpython-{version[0]}{version[1]}-{CROSS}.so"
    definitions = {
        "CMAKE_SYSTEM_NAME": "Linux",
        "CMAKE_SYSTEM_PROCESSOR": "aarch64",
        "CMAKE_CXX_COMPILER": f"{CROSS}-g++",
        "CMAKE_STRIP": shutil.which(f"{CROSS}-strip") or f"{CROSS}-strip",
        "Python_INCLUDE_DIR": include,
        "NB_SUFFIX": suffix,
        "NB_SUFFIX_S": suffix,
    }
    return {
        "CMAKE_ARGS": " ".join(f"-D{name}={value}" for name, value in definitions.items()),
        "SETUPTOOLS_EXT_SUFFIX": suffix,
        "_PYTHON_HOST_PLATFORM": "linux-aarch64",
    }


def main(interpreters: list[str]) -> int:
    """Build all of it; 1 where no interpreter was found."""
    pythons = chosen(interpreters or ["python3"])
    if not pythons:
        return 1
    for folder in (DIST, WORK):
        shutil.rmtree(folder, ignore_errors=True)
    source = sdist()
    cross = shutil.which(f"{CROSS}-g++")
    if not cross:
        print(f"{CROSS}-g++ is not installed; no wheels for aarch64")
    for path, (version, include) in pythons.items():
        name = "cp" + "".join(str(part) for part in version)
        wheel(source, path, name)
        if cross:
            wheel(source, path, f"{name}-aarch64", cross_environment(version, include))
    for made in sorted(DIST.iterdir()):
        print(f"{made.stat().st_size / 1e6:6.1f} MB  {made.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
