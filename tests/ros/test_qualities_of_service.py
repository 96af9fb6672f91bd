"""Publishers with other qualities of service than usual, over DDS within this process."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest
from node_world import SETTINGS
from orbiting_robot import CAMERA, DEPTH, INFO

from circumspect.recording.image_messages import camera_info
from circumspect.recording.pose_messages import transform_message, transforms_message
from circumspect.recording.ros_types import CAMERA_INFO, IMAGE, ODOMETRY, TRANSFORMS
from circumspect.ros.dds_middleware import DdsMiddleware
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.health import Health
from circumspect.ros.live_frames import LiveFrames
from circumspect.ros.middleware import Quality
from circumspect.ros.wire_messages import serialized
from circumspect.sensing.viewing import looking

VOLATILE, LATCHED = Quality(), Quality(latched=True, depth=1)
BEST_EFFORT = Quality(reliable=False)


class Network:
    """Two participants: one that publishes, one that makes frames."""

    def __init__(self, dds: DdsSettings) -> None:
        self._dds = dds
        self.now = 0.0
        self.health = Health(lambda: self.now)
        self.robot = DdsMiddleware(dds, "")
        self._listener: DdsMiddleware | None = None

    def frames(self, **changed: Any) -> LiveFrames:
        self._listener = DdsMiddleware(self._dds, "")
        return LiveFrames(self._listener, replace(SETTINGS, **changed), self.health)

    def close(self) -> None:
        for one in (self._listener, self.robot):
            if one is not None:
                one.close()


@pytest.fixture
def network(dds: DdsSettings) -> Iterator[Network]:
    network = Network(dds)
    yield network
    network.close()


def wait_for(wanted: Callable[[], Any], seconds: float = 20.0) -> Any:
    until = time.monotonic() + seconds
    while not (found := wanted()):
        assert time.monotonic() < until, "it never happened"
        time.sleep(0.02)
    return found


def mount() -> bytes:
    msg = transform_message(looking([0, 0, 1.0], 0.0, 0.4), 0.0, "base_link", "camera")
    return serialized(TRANSFORMS, transforms_message([msg]))


def test_a_camera_info_that_is_latched_once_reaches_a_node_that_joins_later(
    network: Network,
) -> None:
    info = serialized(CAMERA_INFO, camera_info(CAMERA, 1.0, "camera"))
    network.robot.advertise(INFO, CAMERA_INFO, LATCHED)(info)
    network.frames()
    wait_for(lambda: network.health.count("camera info"))


@pytest.mark.parametrize("quality", [VOLATILE, BEST_EFFORT, LATCHED])
def test_static_transforms_of_every_quality_are_received(
    network: Network, quality: Quality
) -> None:
    publish = network.robot.advertise("/tf_static", TRANSFORMS, quality)
    network.frames()

    def received() -> int:
        publish(mount())
        return network.health.count("static transforms")

    wait_for(received)


@pytest.mark.parametrize(
    ("topic", "kind", "what"),
    [(DEPTH, IMAGE, "depth images are"), (INFO, CAMERA_INFO, "CameraInfo are")],
)
def test_a_quality_of_service_that_does_not_match_is_reported_with_the_remedy(
    network: Network, topic: str, kind: str, what: str
) -> None:
    network.robot.advertise(topic, kind, BEST_EFFORT)
    frames = network.frames(reliable=True)
    if topic == DEPTH:
        network.now = 10.0
    else:
        for _ in range(2):
            network.health.on_message("depth")
    missing = wait_for(lambda: "incompatible" in (frames.missing() or "") and frames.missing())
    assert missing == (
        f"{what} published on {topic} with an incompatible quality of service (reliability); "
        "omit --reliable"
    )
    assert frames.odometry_error() == ""


def test_odometry_of_an_incompatible_quality_is_reported(network: Network) -> None:
    network.robot.advertise("/odom", ODOMETRY, BEST_EFFORT)
    frames = network.frames(reliable=True)
    assert "(reliability)" in wait_for(frames.odometry_error)


def test_compatible_qualities_are_not_reported(network: Network) -> None:
    network.robot.advertise(DEPTH, IMAGE, VOLATILE)
    frames = network.frames(reliable=True)
    network.now = 10.0
    missing = wait_for(lambda: "which" in (frames.missing() or "") and frames.missing())
    assert missing == f"no recent depth image on {DEPTH}, which has 1 publisher"
