"""Pose graph: factors between poses, and their optimisation."""

from circumspect.pose_graph.culling import prune_factors, transfer_factors
from circumspect.pose_graph.factors import BetweenFactor, LevelFactor
from circumspect.pose_graph.normal_equations import GraphProblem, GraphState
from circumspect.pose_graph.pose_graph import PoseGraph

__all__ = [
    "BetweenFactor",
    "GraphProblem",
    "GraphState",
    "LevelFactor",
    "PoseGraph",
    "prune_factors",
    "transfer_factors",
]
