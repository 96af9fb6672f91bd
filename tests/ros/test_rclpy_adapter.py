"""The ament package's adapter against a stub of rclpy: no ROS installation has been at hand."""

from __future__ import annotations

import sys
import threading
from enum import Enum
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import pytest
from orbiting_robot import DEPTH, MemoryBus, OrbitingRobot

from circumspect.ros.middleware import COMMANDS, Quality

PACKAGE = Path(__file__).resolve().parents[2] / "ros2" / "circumspect_ros"


class ExternalShutdownError(Exception):
    """Stands for rclpy's."""


class Executor:
    """Serves until it is shut down."""

    def __init__(self) -> None:
        self._over = threading.Event()

    def add_node(self, node: Any) -> None:
        node.served = True

    def spin(self) -> None:
        self._over.wait()
        raise ExternalShutdownError

    def shutdown(self) -> None:
        self._over.set()


class StubNode:
    """The part of `rclpy.node.Node` that the adapter uses, over a bus in memory."""

    def __init__(self, bus: MemoryBus, overrides: dict[str, Any]) -> None:
        self._bus, self.destroyed = bus, False
        self.events: list[tuple[str, Any]] = []
        self.parameters = {"use_sim_time": False, **overrides}

    def create_subscription(
        self, kind: Any, topic: str, callback: Any, qos: Any, *, raw: bool, event_callbacks: Any
    ) -> None:
        assert raw, "the callback takes packed messages"
        self._bus.subscribe(topic, kind, quality_of(qos), callback)
        self.events.append((topic, event_callbacks.incompatible_qos))

    def create_publisher(self, kind: Any, topic: str, qos: Any) -> Any:
        publish = self._bus.advertise(topic, kind, quality_of(qos))

        def checked(data: Any) -> None:
            assert type(data) is bytes, "rclpy takes bytes as packed messages"
            publish(data)

        return SimpleNamespace(publish=checked)

    def count_publishers(self, topic: str) -> int:
        return self._bus.publishers(topic)

    def get_name(self) -> str:
        return "seer"

    def get_namespace(self) -> str:
        return "/robot1"

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Any]:
        assert prefix == ""
        return {name: SimpleNamespace(value=value) for name, value in self.parameters.items()}

    def has_parameter(self, name: str) -> bool:
        return name in self.parameters

    def declare_parameter(self, name: str, value: Any, descriptor: Any) -> None:
        assert name not in self.parameters
        assert value != [] or descriptor.dynamic_typing
        self.parameters[name] = value

    def destroy_node(self) -> None:
        self.destroyed = True


def quality_of(qos: Any) -> Quality:
    reliable, latched = qos.reliability.name == "RELIABLE", qos.durability.name == "TRANSIENT_LOCAL"
    return Quality(reliable, latched, qos.depth)


def module(name: str, **held: Any) -> ModuleType:
    made = ModuleType(name)
    made.__dict__.update(held)
    return made


@pytest.fixture
def bus(monkeypatch: pytest.MonkeyPatch) -> MemoryBus:
    """A bus, and an rclpy whose nodes are on it."""
    bus = MemoryBus()
    stubs = {
        "rclpy": module(
            "rclpy",
            init=lambda args, signal_handler_options: None,
            try_shutdown=lambda: None,
            create_node=lambda name, **keywords: StubNode(bus, bus.overrides),  # type: ignore[attr-defined]
        ),
        "rclpy.executors": module(
            "rclpy.executors",
            SingleThreadedExecutor=Executor,
            ExternalShutdownException=ExternalShutdownError,
        ),
        "rclpy.qos": module(
            "rclpy.qos",
            QoSProfile=lambda **keywords: SimpleNamespace(**keywords),
            HistoryPolicy=Enum("HistoryPolicy", "KEEP_LAST"),
            ReliabilityPolicy=Enum("ReliabilityPolicy", "RELIABLE BEST_EFFORT"),
            DurabilityPolicy=Enum("DurabilityPolicy", "TRANSIENT_LOCAL VOLATILE"),
            qos_policy_name_from_kind=lambda kind: kind,
        ),
        "rclpy.event_handler": module(
            "rclpy.event_handler",
            SubscriptionEventCallbacks=lambda **keywords: SimpleNamespace(**keywords),
        ),
        "rclpy.signals": module(
            "rclpy.signals", SignalHandlerOptions=Enum("SignalHandlerOptions", "NO ALL")
        ),
        "rosidl_runtime_py": module("rosidl_runtime_py"),
        "rosidl_runtime_py.utilities": module(
            "rosidl_runtime_py.utilities", get_message=lambda kind: kind
        ),
        "rcl_interfaces": module("rcl_interfaces"),
        "rcl_interfaces.msg": module(
            "rcl_interfaces.msg", ParameterDescriptor=lambda **keywords: SimpleNamespace(**keywords)
        ),
    }
    for name, stub in stubs.items():
        monkeypatch.setitem(sys.modules, name, stub)
    for name in [name for name in sys.modules if name.startswith("circumspect_ros")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(str(PACKAGE))
    return bus


def test_a_chair_is_named_over_rclpy(bus: Any, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    bus.overrides = {"depth": DEPTH, "rate": 0.0, "queue": 50}
    from circumspect_ros import node as package

    from circumspect.ros.recognition_node import RecognitionNode

    def drive(node: RecognitionNode, goes_on: Any) -> None:
        robot = OrbitingRobot(bus)
        robot.publish_mount()
        for number in range(6):
            robot.publish_frame(number)
        while node.work(0.02) is not None:
            pass
        assert goes_on()
        raise KeyboardInterrupt

    monkeypatch.setattr(RecognitionNode, "spin", drive)
    assert package.main([]) == 0
    received = bus.received("/robot1/seer/detections")[-1]
    assert received.detections[0].results[0].hypothesis.class_id == "chair"
    assert "chair" in capsys.readouterr().out
    assert not bus.wanted[DEPTH][1].reliable
    assert bus.offered["/robot1/seer/model"][1].latched
    assert bus.wanted["/robot1/seer/reset"][1] == COMMANDS


def test_a_quality_of_service_that_does_not_match_is_named(bus: Any) -> None:
    from circumspect_ros.rclpy_middleware import RclpyMiddleware

    stub = StubNode(bus, {})
    middleware = RclpyMiddleware(stub)
    for quality in (Quality(latched=True), Quality()):
        middleware.subscribe("/camera_info", "sensor_msgs/msg/CameraInfo", quality, lambda _: None)
    (_, first), (_, second) = stub.events
    assert middleware.incompatible("/camera_info") == ""
    first(SimpleNamespace(last_policy_kind="DURABILITY_QOS_POLICY"))
    assert middleware.incompatible("/camera_info") == "", "the other subscription receives it"
    second(SimpleNamespace(last_policy_kind="RELIABILITY_QOS_POLICY"))
    assert middleware.incompatible("/camera_info") == "reliability"
    assert middleware.incompatible("/odom") == ""
    middleware.close()


def test_parameters_are_declared_and_misspelt_ones_are_reported(bus: Any, capsys) -> None:
    from circumspect_ros import node as package
    from circumspect_ros.parameters import read_settings

    stub = StubNode(bus, {"mount": (0.1, 0.0, 0.9, 0.0, 30.0), "qos_overrides./tf.depth": 3})
    assert read_settings(stub).mount == (0.1, 0.0, 0.9, 0.0, 30.0)
    assert (stub.parameters["rate"], stub.parameters["box"]) == (5.0, [])
    bus.overrides = {"odomety": "/odom"}
    assert package.main([]) == 2
    assert "did you mean odometry?" in capsys.readouterr().err


def test_the_package_is_complete() -> None:
    root = ElementTree.parse(PACKAGE / "package.xml").getroot()
    assert root.findtext("name") == "circumspect_ros"
    assert root.findtext("export/build_type") == "ament_python"
    needed = {one.text for one in root.iter("depend")}
    assert {"rclpy", "sensor_msgs", "vision_msgs", "diagnostic_msgs"} <= needed
    assert (PACKAGE / "resource" / "circumspect_ros").is_file()
    compile((PACKAGE / "launch" / "circumspect.launch.py").read_text(), "launch", "exec")


def test_its_parameter_file_is_valid() -> None:
    from circumspect.ros.node_settings import NodeSettings, read_parameters

    read = read_parameters(PACKAGE / "config" / "circumspect.yaml", "/circumspect")
    assert NodeSettings.from_parameters(read) == NodeSettings()
