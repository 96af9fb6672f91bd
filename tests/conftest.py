"""What all tests share."""

from __future__ import annotations

import itertools
import os
import signal
from collections.abc import Callable

# Tests run side by side, one core each: more threads would only wait for each other.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# A shell that runs the tests in the background has them ignore Ctrl-C, and the commands that they
# start would inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

ROOT = Path(__file__).resolve().parent.parent

settings.register_profile("default", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("default")


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of development data (`modelnet10/`, `redkitchen/`), or skip."""
    folder = Path(os.environ.get("CIRCUMSPECT_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no development data at {folder}; set CIRCUMSPECT_DATA")
    return folder


@pytest.fixture
def ctrl_c_at(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Arms a Ctrl-C that comes while the pipeline takes its n-th frame, from 1."""
    from circumspect.recognition import RecognitionPipeline

    def arm(frame: int) -> None:
        step, numbers = RecognitionPipeline.step, itertools.count(1)

        def impatient(self, taken):
            if next(numbers) == frame:
                raise KeyboardInterrupt
            return step(self, taken)

        monkeypatch.setattr(RecognitionPipeline, "step", impatient)

    return arm


@pytest.fixture(scope="session")
def chair_obj(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A chair in centimetres with y up, away from the origin."""
    from circumspect.furniture import make_furniture

    mesh = make_furniture("chair", 3)
    lying = 100 * mesh.vertices_xyz[:, [0, 2, 1]] * [1, 1, -1] + [30.0, 7.0, -4.0]
    lines = [f"v {x} {y} {z}" for x, y, z in lying]
    lines += [f"f {a} {b} {c}" for a, b, c in mesh.faces + 1]
    path = tmp_path_factory.mktemp("meshes") / "chair.obj"
    path.write_text("\n".join(lines))
    return path


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CIRCUMSPECT_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))
    # The user's own classifiers are not used either.
    monkeypatch.setenv("CIRCUMSPECT_MODELS", str(tmp_path_factory.getbasetemp() / "models"))
