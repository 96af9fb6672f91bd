"""How DDS is to find others: by the variables that ROS 2 goes by."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Mapping
from dataclasses import dataclass

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
        peers: Hosts that are asked besides.
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
        # The older variable goes before the newer one, as in ROS 2.
        if environ.get("ROS_LOCALHOST_ONLY", "").strip() == "1":
            reach = "LOCALHOST"
        hosts = [host.strip() for host in environ.get("ROS_STATIC_PEERS", "").split(";")]
        peers = tuple(host for host in hosts if host)
        return cls(int(number), reach, peers, environ.get("CYCLONEDDS_URI", "").strip())

    def cyclone(self) -> str:
        """All of it in Cyclone DDS's words; what comes later in the list wins."""
        own = (
            "<CycloneDDS><Domain>"
            f"{self._interfaces()}{self._discovery()}"
            f"<Internal><MaxSampleSize>{LARGEST_SAMPLE} B</MaxSampleSize>"
            '<SocketReceiveBufferSize max="16 MiB"/>'
            # Whoever went without a word must not hold up the end, once for each topic.
            "<WriterLingerDuration>200 ms</WriterLingerDuration></Internal>"
            "</Domain></CycloneDDS>"
        )
        return f"{own},{self.config}" if self.config else own

    def _interfaces(self) -> str:
        if self.reach != "LOCALHOST":
            return ""
        lo = '<NetworkInterface address="127.0.0.1"/>'
        return f"<General><Interfaces>{lo}</Interfaces></General>"

    def _discovery(self) -> str:
        if self.reach == "SYSTEM_DEFAULT":
            return ""
        peers = list(self.peers)
        if self.reach == "LOCALHOST":
            peers = ["127.0.0.1"]
        # Without multicast, participants are found by knocking at the usual ports.
        asked = "".join(f'<Peer address="{peer}"/>' for peer in peers)
        found = f"<Peers>{asked}</Peers>" if asked else ""
        index = "<ParticipantIndex>auto</ParticipantIndex>"
        index += "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
        off = "<General><AllowMulticast>false</AllowMulticast></General>"
        quiet = off if self.reach == "OFF" else ""
        return f"{quiet}<Discovery>{index}{found}</Discovery>"


def _is_host(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return HOST.fullmatch(name) is not None
    return True
