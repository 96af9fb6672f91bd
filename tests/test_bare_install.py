"""Without extras the core works, and everything else names the extra to install."""

import subprocess
import sys

import pytest

from circumspect.furniture import make_furniture
from circumspect.geometry import write_ply

EXTRAS = (
    "torch", "accelerate", "safetensors", "onnx", "onnxscript", "matplotlib", "embreex", "cv2",
    "pupil_apriltags", "viser", "cyclonedds", "ray", "pyarrow", "fsspec",
)  # fmt: skip


BLOCKER = f"""
import sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {EXTRAS!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Blocker())
"""


def without_extras(folder, *words):
    code = (
        f"{BLOCKER}\n"
        "from circumspect.cli.main import main\n"
        f"sys.exit(main({[str(word) for word in words]!r}))"
    )
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=folder)


@pytest.fixture(scope="module")
def chair(tmp_path_factory):
    path = tmp_path_factory.mktemp("files") / "chair.ply"
    write_ply(path, make_furniture("chair", 3).sampled(20_000, 0))
    return path


def test_files_are_named(chair, tmp_path):
    done = without_extras(tmp_path, "classify", chair)
    assert done.returncode == 0, done.stderr
    assert ": chair" in done.stdout


def test_grids_are_saved_without_their_picture(chair, tmp_path):
    done = without_extras(tmp_path, "grid", chair)
    assert done.returncode == 0, done.stderr
    assert "circumspect[figures]" in done.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["chair-grid.npz"]


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        (("demo",), "sim"),
        (("scan", "chair"), "sim"),
        (("train", "--data", "x"), "train"),
        (("nets",), "train"),
        (("export", "a", "b.onnx"), "train"),
        (("locate", "simulate"), "locate"),
        (("locate", "board"), "locate"),
        (("ros2",), "ros2"),
    ],
)
def test_features_that_need_an_extra_name_it(tmp_path, words, extra):
    done = without_extras(tmp_path, *words)
    assert done.returncode == 2
    assert f"circumspect[{extra}]" in done.stderr
    assert done.stderr.count("\n") == 1
