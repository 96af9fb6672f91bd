"""How DDS is to find others: by the variables that ROS 2 goes by."""

from __future__ import annotations

import ipaddress
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from circumspect.errors import InputError

LAST_DOMAIN = 232
"""Of higher domains the ports would be no ports any more."""
LONGEST_NUMBER = 9
"""Of a domain [digits]."""
RANGES = ("OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
LARGEST_SAMPLE = 64 * 2**20
"""Messages of more bytes are thrown away before they are put together."""
HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?")


@dataclass(frozen=True)
class DdsSettings:
    """Where the node is on the network.

    Attributes:
        domain: Number of the DDS domain; only nodes of the same one hear each other.
        reach: One of `RANGES`.
        peers: Hosts that are asked besides, where the reach is LOCALHOST or SUBNET.
        config: Cyclone DDS's own settings, which win over these: XML, or where they are.
    """

    domain: int = 0
    reach: str = "SUBNET"
    peers: tuple[str, ...] = ()
    config: str = ""

    def __post_init__(self) -> None:
        if not 0 <= self.domain <= LAST_DOMAIN:
            raise InputError(f"the ROS domain is 0 to {LAST_DOMAIN}, not {self.domain}")
        if self.reach not in RANGES:
            raise InputError(f"no discovery range {self.reach[:40]!r}; known: {', '.join(RANGES)}")
        for peer in self.peers:
            if not _is_host(peer):
                raise InputError(f"ROS_STATIC_PEERS: {peer[:60]!r} is no host")

    @classmethod
    def from_environment(cls, environ: Mapping[str, str]) -> DdsSettings:
        """What ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE,
        ROS_STATIC_PEERS and CYCLONEDDS_URI say.

        Raises:
            InputError: One of them makes no sense.
        """
        number = environ.get("ROS_DOMAIN_ID", "").strip() or "0"
        if not number.isdecimal() or len(number) > LONGEST_NUMBER:
            raise InputError(
                f"ROS_DOMAIN_ID is {number[:20]!r}; give a number from 0 to {LAST_DOMAIN}"
            )
        reach = environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").strip().upper() or "SUBNET"
        hosts = [host.strip() for host in environ.get("ROS_STATIC_PEERS", "").split(";")]
        peers = tuple(host for host in hosts if host)
        # The older variable goes before the newer ones, as in ROS 2.
        if environ.get("ROS_LOCALHOST_ONLY", "").strip() == "1":
            reach, peers = "LOCALHOST", ()
        return cls(int(number), reach, peers, environ.get("CYCLONEDDS_URI", "").strip())

    def on_this_machine(self) -> DdsSettings:
        """The same, but nobody on another machine, peers included."""
        return replace(self, reach="LOCALHOST", peers=())

    @property
    def where(self) -> str:
        """How others are reached, in words."""
        if self.reach == "OFF":
            return f"of nobody (discovery is OFF), domain {self.domain}"
        if self.reach != "LOCALHOST":
            return f"on the network, domain {self.domain}"
        besides = " and the ROS_STATIC_PEERS" if self.peers else ""
        return f"on this machine{besides}, domain {self.domain}"

    def cyclone(self) -> str:
        """All of it in Cyclone DDS's words; what comes later in the list wins."""
        own = (
            "<CycloneDDS><Domain>"
            f"<General>{self._general()}</General>"
            f"<Discovery>{self._discovery()}</Discovery>"
            f"<Internal><MaxSampleSize>{LARGEST_SAMPLE} B</MaxSampleSize>"
            '<SocketReceiveBufferSize max="16 MiB"/>'
            # Whoever went without a word must not hold up the end, once for each topic.
            "<WriterLingerDuration>200 ms</WriterLingerDuration></Internal>"
            "</Domain></CycloneDDS>"
        )
        return f"{own},{self.config}" if self.config else own

    def _general(self) -> str:
        # Peers on other machines are not reached over loopback.
        if self.reach == "LOCALHOST" and not self.peers:
            return '<Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'
        quiet = self.reach in ("OFF", "LOCALHOST")
        return "<AllowMulticast>false</AllowMulticast>" if quiet else ""

    def _discovery(self) -> str:
        if self.reach == "SYSTEM_DEFAULT":
            return ""
        if self.reach == "OFF":
            # Others find no port to knock at, and would have to give the same tag.
            tag = f"circumspect_discovery_off_{os.getpid()}"
            return f"<ParticipantIndex>none</ParticipantIndex><Tag>{tag}</Tag>"
        # Without multicast, participants are found by knocking at the usual ports.
        here = ("127.0.0.1",) if self.reach == "LOCALHOST" else ()
        asked = "".join(f'<Peer address="{peer}"/>' for peer in (*here, *self.peers))
        found = f"<Peers>{asked}</Peers>" if asked else ""
        index = "<ParticipantIndex>auto</ParticipantIndex>"
        return f"{index}<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>{found}"


def _is_host(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return HOST.fullmatch(name) is not None
    return True
