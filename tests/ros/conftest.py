"""Nodes over a bus in memory, and the other end of the wire: RustDDS by ros2-client."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from node_world import SETTINGS
from orbiting_robot import MemoryBus

from circumspect.classification import Classifier
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.recognition_node import RecognitionNode

HERE = Path(__file__).resolve().parent
TARGET = HERE.parents[1] / "build" / "ros2-peer"
OFFLINE = ("failed to download", "failed to get", "Could not resolve", "download of")


@pytest.fixture(scope="module")
def classifier() -> Classifier:
    return Classifier.load(threads=1)


@pytest.fixture
def bus() -> MemoryBus:
    return MemoryBus()


@pytest.fixture
def made(bus: MemoryBus, classifier: Classifier) -> Iterator[Any]:
    """Makes nodes with other settings than usual."""
    nodes: list[RecognitionNode] = []

    def make(**changed: Any) -> RecognitionNode:
        nodes.append(RecognitionNode(bus, replace(SETTINGS, **changed), classifier))
        return nodes[-1]

    yield make
    for node in nodes:
        node.close()


@pytest.fixture
def node(made: Any) -> RecognitionNode:
    return made()


@pytest.fixture(scope="session")
def dds() -> DdsSettings:
    """A domain of this process alone, on this machine alone."""
    return DdsSettings(20 + os.getpid() % 200, "LOCALHOST")


@pytest.fixture(scope="session")
def peer_program() -> Path:
    cargo = shutil.which("cargo")
    if cargo is None:
        pytest.skip("no cargo: the independent ROS 2 peer can not be built; see rustup.rs")
    words = [cargo, "build", "--locked", "--quiet", "--target-dir", str(TARGET)]
    done = subprocess.run(words, cwd=HERE / "peer", capture_output=True, text=True, timeout=1200)
    if done.returncode and any(word in done.stderr for word in OFFLINE):
        pytest.skip("the crates of the independent ROS 2 peer can not be fetched")
    assert done.returncode == 0, done.stderr
    return TARGET / "debug" / "ros2-peer"


class Peer:
    """A process of the other implementation; its lines are collected."""

    def __init__(self, program: Path, domain: int, words: list[str], log: Path) -> None:
        self._log = log
        with log.open("w") as stream:
            self._process = subprocess.Popen(
                [program, str(domain), *words],
                stdin=subprocess.PIPE,
                stdout=stream,
                stderr=subprocess.STDOUT,
                text=True,
            )

    def lines(self, topic: str | None = None) -> list[dict[str, Any]]:
        """The JSON lines so far."""
        whole = [line for line in self._log.read_text().splitlines() if line.startswith("{")]
        found = [json.loads(line) for line in whole if line.endswith("}")]
        return [line for line in found if topic is None or line.get("topic") == topic]

    def wait_for(self, wanted: Callable[[], Any], what: str, seconds: float = 60.0) -> Any:
        """What `wanted` gives as soon as it gives something."""
        until = time.monotonic() + seconds
        while not (found := wanted()):
            assert time.monotonic() < until, f"no {what}: {self._log.read_text()[-2000:]}"
            time.sleep(0.05)
        return found

    def go(self) -> None:
        """Start a talker that waits for its subscribers."""
        assert self._process.stdin is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()

    def let_go(self) -> None:
        """Close its standard input: it need not wait for anything."""
        assert self._process.stdin is not None
        self._process.stdin.close()

    def ended(self, seconds: float = 90.0) -> list[dict[str, Any]]:
        """Wait for its end; all of its lines."""
        self.let_go()
        code = self._process.wait(seconds)
        assert code == 0, self._log.read_text()[-2000:]
        return self.lines()

    def kill(self) -> None:
        self.let_go()
        self._process.kill()
        self._process.wait()


@pytest.fixture
def peer(peer_program: Path, dds: DdsSettings, tmp_path: Path) -> Iterator[Callable[..., Peer]]:
    """Starts peers: `peer("listen", "circumspect", "20")`."""
    begun: list[Peer] = []

    def begin(*words: str) -> Peer:
        log = tmp_path / f"peer-{len(begun)}.log"
        begun.append(Peer(peer_program, dds.domain, [str(word) for word in words], log))
        return begun[-1]

    yield begin
    for one in begun:
        one.kill()
