"""Untrusted ONNX files: refused before they run, or stopped while they run."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import hostile_networks
import numpy as np
import onnx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.classification import Classifier, input_spec_from_dict
from circumspect.classification.model_description import METADATA_KEY
from circumspect.classification.onnx_inspection import MAX_MEMORY_BYTES, require_plain_network
from circumspect.classification.shipped import shipped_path
from circumspect.errors import InputError, WeightsError

NOTHING = np.zeros((1, 1, 1, 32, 32, 32), np.uint8)


def written(tmp_path: Path, network: onnx.ModelProto) -> Path:
    path = tmp_path / "hostile.onnx"
    path.write_bytes(network.SerializeToString())
    return path


def test_plain_networks_are_taken(tmp_path):
    require_plain_network(shipped_path("modelnet10").read_bytes())
    classifier = Classifier.load(written(tmp_path, hostile_networks.harmless()))
    np.testing.assert_allclose(classifier.probabilities(NOTHING), 0.1)


@pytest.mark.parametrize("kind", hostile_networks.REFUSED)
def test_refused_before_it_runs(kind, tmp_path, monkeypatch):
    (tmp_path / "passwords").write_bytes(bytes(40))
    monkeypatch.chdir(tmp_path)
    make, why = hostile_networks.REFUSED[kind]
    with pytest.raises(WeightsError, match=why) as error:
        Classifier.load(written(tmp_path, make()))
    assert str(error.value).startswith(f"{tmp_path / 'hostile.onnx'}: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("kind", hostile_networks.FAILING)
def test_stopped_while_it_runs(kind, tmp_path):
    """In a process of its own, whose memory is measured.

    By VmHWM: to `ru_maxrss` a new process brings what its parent had.
    """
    path = written(tmp_path, hostile_networks.FAILING[kind]())
    program = (
        "import re, sys, numpy as np\n"
        "from pathlib import Path\n"
        "from circumspect.classification import Classifier\n"
        "from circumspect.errors import WeightsError\n"
        "try:\n"
        "    Classifier.load(sys.argv[1], 1).scores(np.zeros((1, 1, 1, 32, 32, 32), np.uint8))\n"
        "except WeightsError:\n"
        "    status = Path('/proc/self/status').read_text()\n"
        "    print(1024 * int(re.search(r'VmHWM:\\s+(\\d+) kB', status)[1]))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, path], capture_output=True, text=True, timeout=120
    )
    assert done.stderr == ""
    assert int(done.stdout) < MAX_MEMORY_BYTES + 300_000_000


def described(change) -> bytes:
    network = onnx.load_from_string(shipped_path("modelnet10").read_bytes())
    (entry,) = network.metadata_props
    entry.value = change if isinstance(change, str) else json.dumps(change(json.loads(entry.value)))
    return network.SerializeToString()


@pytest.mark.parametrize(
    "change",
    [
        "[" * 200_000,
        "[]",
        "7",
        '"text"',
        lambda d: {**d, "classes": "abcdefghij"},
        lambda d: {**d, "classes": list(range(10))},
        lambda d: {**d, "classes": [[], {}] * 5},
        lambda d: {**d, "classes": ["\x1b[2J", *d["classes"][1:]]},
        lambda d: {**d, "classes": ["x" * 10_000, *d["classes"][1:]]},
        lambda d: {**d, "grid": "cylindrical"},
        lambda d: {**d, "grid": {**d["grid"], "azimuth_views": 10**9}},
        lambda d: {**d, "grid": {**d["grid"], "fill_samples": 10**12}},
        lambda d: {**d, "grid": {**d["grid"], "shape": [2**40, 2**40, 2**40]}},
        lambda d: {**d, "grid": {**d["grid"], "shape": "123"}},
        lambda d: {**d, "grid": {"kind": "points", "count": 10**12}},
    ],
)
def test_invalid_descriptions_are_refused(change, tmp_path):
    path = tmp_path / "described.onnx"
    path.write_bytes(described(change))
    with pytest.raises(WeightsError, match=r"described\.onnx") as error:
        Classifier.load(path)
    assert len(str(error.value)) < 1000
    assert str(error.value).isprintable()


def test_special_files_are_refused(tmp_path):
    import os

    os.mkfifo(tmp_path / "pipe.onnx")
    with pytest.raises(WeightsError, match="not a regular file"):
        Classifier.load(tmp_path / "pipe.onnx")
    with (tmp_path / "large.onnx").open("wb") as stream:
        stream.truncate(2**40)
    with pytest.raises(WeightsError, match="larger than 512 MiB"):
        Classifier.load(tmp_path / "large.onnx")


def test_a_broken_network_prints_nothing_on_standard_output(tmp_path, capfd):
    """ONNX Runtime by itself prints there that it tries again."""
    network = hostile_networks.harmless()
    network.graph.node[0].input[0] = "lacking"
    path = tmp_path / "broken.onnx"
    path.write_bytes(network.SerializeToString().replace(b"lacking", b"\xfeacking"))
    with pytest.raises(WeightsError, match="not an ONNX network"):
        Classifier.load(path)
    assert capfd.readouterr().out == ""


@given(data=st.binary(max_size=300))
@settings(max_examples=200)
def test_noise_is_refused(data):
    with suppress(WeightsError):
        require_plain_network(data)


def test_input_spec_counts_are_bounded():
    with pytest.raises(InputError, match="azimuth_views must be a whole number from 1 to 64"):
        input_spec_from_dict({"azimuth_views": 65})
    with pytest.raises(InputError, match="an object"):
        input_spec_from_dict(["cylindrical"])  # type: ignore[arg-type]


def test_the_description_is_found_under_its_key():
    assert METADATA_KEY.encode() in shipped_path("modelnet10").read_bytes()
