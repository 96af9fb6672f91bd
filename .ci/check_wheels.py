"""What dist/ holds, installed and tried in clean environments.

    python .ci/check_wheels.py python3.11 python3.12   # the sdist and the wheel that fits each
    python .ci/check_wheels.py --here                  # the environment that runs this, as it is

Versions of other packages follow PIP_CONSTRAINT. Each environment says its version, classifies a
chair and runs `circumspect demo --seed 7`. The results must be the same in all of them.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
DIST = ROOT / "dist"
MAKE_CHAIR = (
    "import circumspect as cs; "
    "cs.write_ply('chair.ply', cs.make_furniture('chair', 3).sampled(20_000, rng=0))"
)
WHERE = "import circumspect, pathlib; print(pathlib.Path(circumspect.__file__).parent)"
UNEQUAL = ("milliseconds", "run")
"""Keys of results that name times and the folder of the run."""


def run(folder: Path, *command: str | Path) -> str:
    """Run a command in a folder, without this environment's Python path; its output."""
    words = [str(word) for word in command]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    environment["OMP_NUM_THREADS"] = "1"
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.stderr.write(done.stdout + done.stderr)
        raise SystemExit(f"failed with {done.returncode}: {' '.join(words)}")
    return done.stdout


def comparable(result: Any) -> Any:
    """A result without the keys that differ between runs."""
    if isinstance(result, list):
        return [comparable(one) for one in result]
    if isinstance(result, dict):
        kept = {name: value for name, value in result.items() if name not in UNEQUAL}
        return {name: comparable(value) for name, value in kept.items()}
    return result


def results(binaries: Path) -> dict[str, Any]:
    """What an environment answers.

    Raises:
        SystemExit: A command fails, or an answer is wrong.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        place = Path(run(folder, binaries / "python", "-c", WHERE).strip())
        if place.is_relative_to(ROOT / "src") or not (place / "py.typed").is_file():
            raise SystemExit(f"{place} is not an installed package")
        version = run(folder, binaries / "circumspect", "--version").strip()
        run(folder, binaries / "python", "-c", MAKE_CHAIR)
        chair = json.loads(run(folder, binaries / "circumspect", "classify", "chair.ply", "--json"))
        if chair["label"] != "chair":
            raise SystemExit(f"the chair is classified as {chair['label']}")
        words = ("demo", "--seed", "7", "--json", "--out", "run")
        demo = json.loads(run(folder, binaries / "circumspect", *words))
    return {"version": version, "chair": comparable(chair), "demo": comparable(demo)}


def environment(python: str, package: Path, folder: Path) -> Path:
    """A new environment with a wheel or the sdist and the extra `sim`; its bin folder."""
    shutil.rmtree(folder, ignore_errors=True)
    run(ROOT, python, "-m", "venv", folder)
    run(ROOT, folder / "bin" / "python", "-m", "pip", "install", "--quiet", f"{package}[sim]")
    return folder / "bin"


def wheel_for(python: str) -> Path | None:
    """The wheel of dist/ for an interpreter and this machine's processor."""
    asked = subprocess.run(
        [python, "-c", "import sys; print(*sys.version_info[:2])"], capture_output=True, text=True
    )
    major, minor = (int(part) for part in asked.stdout.split())
    tag = "cp312-abi3" if (major, minor) >= (3, 12) else f"cp{major}{minor}-cp{major}{minor}"
    return next(DIST.glob(f"*-{tag}-*{platform.machine()}.whl"), None)


def packages(interpreters: list[str]) -> list[tuple[str, Path]]:
    """Interpreters with what is installed in each: its wheel, and the sdist in the first."""
    found = [path for path in map(shutil.which, interpreters) if path]
    wheels = [(path, wheel) for path in found if (wheel := wheel_for(path))]
    return [*wheels, *((path, source) for path in found[:1] for source in DIST.glob("*.tar.gz"))]


def main(arguments: list[str]) -> int:
    """Try all environments; 1 where they differ or none could be made."""
    if arguments == ["--here"]:
        print(json.dumps(results(Path(sys.executable).parent)))
        return 0
    first: dict[str, Any] = {}
    for number, (python, package) in enumerate(packages(arguments)):
        binaries = environment(python, package, ROOT / "build" / "check" / str(number))
        answers = results(binaries)
        first = first or answers
        same = answers == first
        print(f"{'same' if same else 'DIFFERENT'}: {package.name} in {python}", flush=True)
        if not same:
            print(json.dumps(first), json.dumps(answers), sep="\n")
            return 1
    if not first:
        print("nothing to check: run make dist first")
    return 0 if first else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
