"""DDS settings from ROS environment variables, and type names and hashes on the wire."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from xml.etree import ElementTree

import pytest

from circumspect.errors import InputError
from circumspect.recording.ros_types import IMAGE, typestore
from circumspect.ros.dds_middleware import DdsMiddleware
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.dds_types import dds_type, serialized_type
from circumspect.ros.middleware import LATEST

PROCESS = """
import os, sys, time
from circumspect.ros.dds_middleware import DdsMiddleware
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.middleware import LATEST

seconds, here, there = float(sys.argv[1]), *sys.argv[2:]
kind = "std_msgs/msg/String"
air = DdsMiddleware(DdsSettings.from_environment(os.environ), "")
publish = air.advertise(here, kind, LATEST)
air.subscribe(there, kind, LATEST, lambda data: None)
until = time.monotonic() + seconds
while not air.publishers(there) and time.monotonic() < until:
    time.sleep(0.05)
print(air.publishers(there))
time.sleep(2)  # the later process still finds the other
air.close()
"""
"""Publishes on one topic and looks for a publisher of another."""


def xml(settings: DdsSettings) -> ElementTree.Element:
    return ElementTree.fromstring(settings.cyclone().split(",")[0])


def test_default_is_domain_0_on_the_subnet() -> None:
    settings = DdsSettings.from_environment({})
    assert (settings.domain, settings.discovery_range) == (0, "SUBNET")
    assert xml(settings).find(".//NetworkInterface") is None


@pytest.mark.parametrize(
    "environ", [{"ROS_LOCALHOST_ONLY": "1"}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "localhost"}]
)
def test_this_machine_only(environ: dict[str, str]) -> None:
    found = xml(DdsSettings.from_environment(environ))
    assert [one.get("address") for one in found.iter("NetworkInterface")] == ["127.0.0.1"]
    assert [one.get("address") for one in found.iter("Peer")] == ["127.0.0.1"]


@pytest.mark.parametrize(
    ("discovery_range", "addresses"), [("SUBNET", []), ("LOCALHOST", ["127.0.0.1"])]
)
def test_static_peers_are_added(discovery_range: str, addresses: list[str]) -> None:
    environ = {"ROS_AUTOMATIC_DISCOVERY_RANGE": discovery_range, "ROS_STATIC_PEERS": "10.0.0.7"}
    settings = DdsSettings.from_environment(environ)
    found = xml(settings)
    assert [one.get("address") for one in found.iter("Peer")] == [*addresses, "10.0.0.7"]
    # Loopback does not lead to them; no other node is to find them.
    assert found.find(".//NetworkInterface") is None
    quiet = found.findtext(".//AllowMulticast")
    assert quiet == ("false" if discovery_range == "LOCALHOST" else None)


def test_localhost_only_removes_static_peers() -> None:
    peers = {"ROS_STATIC_PEERS": "10.0.0.7"}
    older = DdsSettings.from_environment({**peers, "ROS_LOCALHOST_ONLY": "1"})
    assert older == DdsSettings.from_environment(peers).local_only()
    assert (older.discovery_range, older.peers) == ("LOCALHOST", ())


@pytest.mark.parametrize(
    ("discovery_range", "peers", "text"),
    [
        ("OFF", ("10.0.0.7",), "with nobody (discovery is OFF), domain 3"),
        ("LOCALHOST", (), "on this machine, domain 3"),
        ("LOCALHOST", ("10.0.0.7",), "on this machine and the ROS_STATIC_PEERS, domain 3"),
        ("SUBNET", (), "on the network, domain 3"),
    ],
)
def test_the_description_names_where_other_nodes_are(
    discovery_range: str, peers: tuple[str, ...], text: str
) -> None:
    assert DdsSettings(3, discovery_range, peers).description == text


def publishers_found(environ: dict[str, str], seconds: float) -> tuple[int, int]:
    """How many publishers each of two processes, started alike, finds of the other."""
    words = [sys.executable, "-W", "error", "-c", PROCESS, str(seconds)]
    both = [
        subprocess.Popen([*words, here, there], stdout=subprocess.PIPE, text=True, env=environ)
        for here, there in (("/one", "/other"), ("/other", "/one"))
    ]
    outputs = [one.communicate(timeout=60)[0] for one in both]
    assert [one.returncode for one in both] == [0, 0]
    return int(outputs[0]), int(outputs[1])


@pytest.mark.parametrize("discovery_range", ["OFF", "LOCALHOST"])
def test_two_processes_on_this_machine(dds: DdsSettings, discovery_range: str) -> None:
    environ = {
        **os.environ,
        "ROS_DOMAIN_ID": str(dds.domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": discovery_range,
        # Where discovery is off, not even static peers are contacted.
        "ROS_STATIC_PEERS": "127.0.0.1" if discovery_range == "OFF" else "",
    }
    received = publishers_found(environ, 4 if discovery_range == "OFF" else 30)
    assert received == ((0, 0) if discovery_range == "OFF" else (1, 1))


def test_static_peers_and_own_settings() -> None:
    settings = DdsSettings.from_environment(
        {"ROS_STATIC_PEERS": "10.0.0.7; robot.local", "CYCLONEDDS_URI": "file:///etc/dds.xml"}
    )
    assert [one.get("address") for one in xml(settings).iter("Peer")] == ["10.0.0.7", "robot.local"]
    assert settings.cyclone().endswith(",file:///etc/dds.xml")


def test_the_own_settings_win() -> None:
    """Cyclone applies the last value of a setting; an invalid one shows that it was received."""
    broken = "<CycloneDDS><Domain><Internal><MaxSampleSize>much</MaxSampleSize></Internal></Domain></CycloneDDS>"
    with pytest.raises(InputError, match="can not join domain 231"):
        DdsMiddleware(DdsSettings(231, "LOCALHOST", config=broken), "")


@pytest.mark.parametrize(
    ("environ", "said"),
    [
        ({"ROS_DOMAIN_ID": "x"}, "ROS_DOMAIN_ID is 'x'"),
        ({"ROS_DOMAIN_ID": "300"}, "0 to 232"),
        ({"ROS_DOMAIN_ID": "9" * 5000}, "ROS_DOMAIN_ID is '9{20}'; give a number from 0 to 232"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "galaxy"}, "known: OFF, LOCALHOST"),
        ({"ROS_STATIC_PEERS": "a<b"}, "is not a host"),
    ],
)
def test_invalid_variables_are_refused(environ: dict[str, str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        DdsSettings.from_environment(environ)


def test_type_names_and_hashes() -> None:
    assert dds_type(IMAGE) == "sensor_msgs::msg::dds_::Image_"
    # As `ros2 topic info --verbose` of ROS 2 Jazzy prints it.
    assert typestore().hash_rihs01("std_msgs/msg/String") == (
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    )
    assert serialized_type(IMAGE) is serialized_type(IMAGE)


def test_late_subscribers_get_the_last_message_and_early_ones_every_message(
    dds: DdsSettings,
) -> None:
    one, other = DdsMiddleware(dds, ""), DdsMiddleware(dds, "")
    kind = "std_msgs/msg/String"
    publish = one.advertise("/said", kind, LATEST)
    received: list[bytes] = []
    words = [b"\0\1\0\0\4\0\0\0" + word + b"\0" for word in (b"abc", b"def")]
    publish(words[0])
    other.subscribe("/said", kind, LATEST, received.append)
    for number, word in enumerate(words):
        publish(word) if number else None
        until = time.monotonic() + 20
        while len(received) <= number and time.monotonic() < until:
            time.sleep(0.01)
    assert received == words
    assert (other.publishers("/said"), other.publishers("/else"), other.lost) == (1, 0, 0)
    one.close()
    other.close()
    one.close()
    publish(words[0])  # after the end nothing happens
