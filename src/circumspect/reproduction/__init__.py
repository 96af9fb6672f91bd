"""Whole experiments by one command: trained, measured, and set beside what was published."""

from circumspect.reproduction.rivals import Rivals, reproduce_rivals
from circumspect.reproduction.table2 import Table2, reproduce_table2

__all__ = ["Rivals", "Table2", "reproduce_rivals", "reproduce_table2"]
