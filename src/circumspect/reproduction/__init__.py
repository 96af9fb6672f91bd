"""Whole experiments by one command: trained, measured, and set beside what was published."""

from circumspect.reproduction.contenders import Comparison
from circumspect.reproduction.real import RealObjects, reproduce_real
from circumspect.reproduction.rivals import reproduce_rivals
from circumspect.reproduction.robot_scans import RobotScans
from circumspect.reproduction.robustness import reproduce_robustness
from circumspect.reproduction.table2 import Table2, reproduce_table2
from circumspect.reproduction.table2_robot import reproduce_robot
from circumspect.reproduction.unknown import Unknown, reproduce_unknown

__all__ = [
    "Comparison",
    "RealObjects",
    "RobotScans",
    "Table2",
    "Unknown",
    "reproduce_real",
    "reproduce_rivals",
    "reproduce_robot",
    "reproduce_robustness",
    "reproduce_table2",
    "reproduce_unknown",
]
