"""Networks in torch: layers on the azimuth circle, the registry, checkpoints."""

from circumspect.nets.checkpoint import Checkpoint
from circumspect.nets.cost import Cost, cost_of
from circumspect.nets.registry import NETS, NetSpec, build_net

__all__ = ["NETS", "Checkpoint", "Cost", "NetSpec", "build_net", "cost_of"]
