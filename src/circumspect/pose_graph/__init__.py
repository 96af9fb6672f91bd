"""Pose graph: factors between poses, their optimisation and marginals, keyframes, loop closures."""

from circumspect.pose_graph.culling import prune_factors, transfer_factors
from circumspect.pose_graph.factors import BetweenFactor, LevelFactor
from circumspect.pose_graph.keyframe import Keyframe
from circumspect.pose_graph.keyframe_graph import KeyframeSettings
from circumspect.pose_graph.keyframe_map import KeyframeMap
from circumspect.pose_graph.normal_equations import GraphProblem, GraphState
from circumspect.pose_graph.pose_graph import PoseGraph, marginal_covariances

__all__ = [
    "BetweenFactor",
    "GraphProblem",
    "GraphState",
    "Keyframe",
    "KeyframeMap",
    "KeyframeSettings",
    "LevelFactor",
    "PoseGraph",
    "marginal_covariances",
    "prune_factors",
    "transfer_factors",
]
