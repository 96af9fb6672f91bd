"""Whole experiments by one command: trained, measured, and set beside what was published."""

from circumspect.reproduction.rivals import Rivals, reproduce_rivals
from circumspect.reproduction.table2 import Table2, reproduce_table2
from circumspect.reproduction.table2_robot import reproduce_robot
from circumspect.reproduction.unknown import Unknown, reproduce_unknown

__all__ = [
    "Rivals",
    "Table2",
    "Unknown",
    "reproduce_rivals",
    "reproduce_robot",
    "reproduce_table2",
    "reproduce_unknown",
]
