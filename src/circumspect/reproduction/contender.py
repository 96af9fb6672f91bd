"""One row of a comparison: a network, and the yaws that it is trained at."""

from __future__ import annotations

from dataclasses import dataclass, replace

from circumspect.nets.registry import NetSpec, net_spec, net_words, require_turnable
from circumspect.training import TrainingSettings

SUFFIX = "-random-yaw"
"""Of the names of rows that are trained at random yaw."""


@dataclass(frozen=True)
class Contender:
    """A network that is trained at 0° alone, or at random yaw.

    Attributes:
        net: Name of the network.
        random_yaw: Its training objects are turned about the vertical at random.
    """

    net: str
    random_yaw: bool = False

    @classmethod
    def from_name(cls, name: str) -> Contender:
        """Read the name of a row: NET, or NET-random-yaw.

        Raises:
            InputError: No network of that name, or it can not be trained at random yaw.
        """
        net = name.removesuffix(SUFFIX)
        random_yaw = net != name
        if random_yaw:
            require_turnable(net)
        return cls(net_spec(net).name, random_yaw)

    @property
    def words(self) -> str:
        """What to type for it: its name, or MODULE:NAME of a network that is not installed."""
        return net_words(self.net) + (SUFFIX if self.random_yaw else "")

    @property
    def name(self) -> str:
        """On the command line, in files and as its folder."""
        return f"{self.net}{SUFFIX}" if self.random_yaw else self.net

    @property
    def label(self) -> str:
        """In tables and pictures."""
        return f"{self.net}, trained at random yaw" if self.random_yaw else self.net

    @property
    def spec(self) -> NetSpec:
        """The network."""
        return net_spec(self.net)

    @property
    def settings(self) -> TrainingSettings:
        """As the network is meant to be trained; at random yaw with as many variants as usual."""
        meant = TrainingSettings.of_net(self.spec)
        if not self.random_yaw:
            return meant
        replicas = max(meant.replicas, TrainingSettings.replicas)
        return replace(meant, random_yaw=True, replicas=replicas)
