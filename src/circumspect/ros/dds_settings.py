"""DDS discovery settings from the environment variables of ROS 2."""

from __future__ import annotations

import ipaddress
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from circumspect.errors import InputError

MAX_DOMAIN = 232
"""Maximum domain; higher ones have no valid ports."""
MAX_DOMAIN_DIGITS = 9
"""Maximum number of digits of a domain."""
RANGES = ("OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
MAX_SAMPLE_BYTES = 64 * 2**20
"""Maximum message size [bytes]; larger messages are dropped before they are assembled."""
HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?")


@dataclass(frozen=True)
class DdsSettings:
    """Network settings of the node.

    Attributes:
        domain: DDS domain; only nodes of the same domain communicate.
        discovery_range: One of `RANGES`.
        peers: Additional hosts, for the ranges LOCALHOST and SUBNET.
        config: Additional settings of Cyclone DDS, which take precedence: XML or its location.
    """

    domain: int = 0
    discovery_range: str = "SUBNET"
    peers: tuple[str, ...] = ()
    config: str = ""

    def __post_init__(self) -> None:
        if not 0 <= self.domain <= MAX_DOMAIN:
            raise InputError(f"the ROS domain is 0 to {MAX_DOMAIN}, not {self.domain}")
        if self.discovery_range not in RANGES:
            raise InputError(
                f"no discovery range {self.discovery_range[:40]!r}; known: {', '.join(RANGES)}"
            )
        for peer in self.peers:
            if not _is_host(peer):
                raise InputError(f"ROS_STATIC_PEERS: {peer[:60]!r} is not a host")

    @classmethod
    def from_environment(cls, environ: Mapping[str, str]) -> DdsSettings:
        """Read ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE,
        ROS_STATIC_PEERS and CYCLONEDDS_URI.

        Raises:
            InputError: A value is invalid.
        """
        number = environ.get("ROS_DOMAIN_ID", "").strip() or "0"
        if not number.isdecimal() or len(number) > MAX_DOMAIN_DIGITS:
            raise InputError(
                f"ROS_DOMAIN_ID is {number[:20]!r}; give a number from 0 to {MAX_DOMAIN}"
            )
        discovery_range = (
            environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").strip().upper() or "SUBNET"
        )
        hosts = [host.strip() for host in environ.get("ROS_STATIC_PEERS", "").split(";")]
        peers = tuple(host for host in hosts if host)
        # The older variable takes precedence, as in ROS 2.
        if environ.get("ROS_LOCALHOST_ONLY", "").strip() == "1":
            discovery_range, peers = "LOCALHOST", ()
        return cls(int(number), discovery_range, peers, environ.get("CYCLONEDDS_URI", "").strip())

    def local_only(self) -> DdsSettings:
        """The same settings restricted to this machine, without peers."""
        return replace(self, discovery_range="LOCALHOST", peers=())

    @property
    def description(self) -> str:
        """How other nodes are reached, as text."""
        if self.discovery_range == "OFF":
            return f"with nobody (discovery is OFF), domain {self.domain}"
        if self.discovery_range != "LOCALHOST":
            return f"on the network, domain {self.domain}"
        besides = " and the ROS_STATIC_PEERS" if self.peers else ""
        return f"on this machine{besides}, domain {self.domain}"

    def cyclone(self) -> str:
        """The settings in the format of Cyclone DDS; later entries take precedence."""
        settings = (
            "<CycloneDDS><Domain>"
            f"<General>{self._general()}</General>"
            f"<Discovery>{self._discovery()}</Discovery>"
            f"<Internal><MaxSampleSize>{MAX_SAMPLE_BYTES} B</MaxSampleSize>"
            '<SocketReceiveBufferSize max="16 MiB"/>'
            # A peer that vanished must not delay the shutdown, once for each topic.
            "<WriterLingerDuration>200 ms</WriterLingerDuration></Internal>"
            "</Domain></CycloneDDS>"
        )
        return f"{settings},{self.config}" if self.config else settings

    def _general(self) -> str:
        # Peers on other machines are not reachable over loopback.
        if self.discovery_range == "LOCALHOST" and not self.peers:
            return '<Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'
        is_local = self.discovery_range in ("OFF", "LOCALHOST")
        return "<AllowMulticast>false</AllowMulticast>" if is_local else ""

    def _discovery(self) -> str:
        if self.discovery_range == "SYSTEM_DEFAULT":
            return ""
        if self.discovery_range == "OFF":
            # Other nodes would need the same tag and find no port.
            tag = f"circumspect_discovery_off_{os.getpid()}"
            return f"<ParticipantIndex>none</ParticipantIndex><Tag>{tag}</Tag>"
        # Without multicast, participants are found at the default ports.
        local = ("127.0.0.1",) if self.discovery_range == "LOCALHOST" else ()
        addresses = "".join(f'<Peer address="{peer}"/>' for peer in (*local, *self.peers))
        peers = f"<Peers>{addresses}</Peers>" if addresses else ""
        index = "<ParticipantIndex>auto</ParticipantIndex>"
        return f"{index}<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>{peers}"


def _is_host(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return HOST.fullmatch(name) is not None
    return True
