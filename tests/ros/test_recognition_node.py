"""The node over a bus in memory: all of its logic, none of the network."""

from __future__ import annotations

import time

import pytest
from orbiting_robot import DEPTH, MemoryBus, OrbitingRobot

from circumspect.classification import Classifier
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.recognition_node import RecognitionNode


@pytest.fixture(scope="module")
def classifier() -> Classifier:
    return Classifier.load(threads=1)


@pytest.fixture
def bus() -> MemoryBus:
    return MemoryBus()


@pytest.fixture
def node(bus: MemoryBus, classifier: Classifier):
    made = RecognitionNode(bus, NodeSettings(depth=DEPTH, rate=0.0, queue=50), classifier)
    yield made
    made.close()


def worked_off(node: RecognitionNode) -> list:
    steps = []
    while (step := node.work(timeout=0.05)) is not None:
        steps.append(step)
    return steps


def test_a_chair_is_named(bus, node):
    robot = OrbitingRobot(bus)
    robot.stand()
    t = time.time()
    for number in range(20):
        robot.drive(number)
    steps = worked_off(node)
    print([s.outcome for s in steps], time.time() - t)
    print(steps[-1].summary())
    print({k: len(v) for k, v in bus.heard.items()})
    print(bus.told("/circumspect/next_view"))
