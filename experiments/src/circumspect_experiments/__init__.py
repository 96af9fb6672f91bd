"""Experiments that run with one command, and compare results with published ones."""

from typing import TYPE_CHECKING

from circumspect.lazy_names import lazy_names

if TYPE_CHECKING:
    from circumspect_experiments.contenders import Comparison
    from circumspect_experiments.real import RealObjects, reproduce_real
    from circumspect_experiments.rivals import reproduce_rivals
    from circumspect_experiments.robot_answers import RobotScans
    from circumspect_experiments.robustness import reproduce_robustness
    from circumspect_experiments.table2 import Table2, reproduce_table2
    from circumspect_experiments.table2_robot import reproduce_robot
    from circumspect_experiments.unknown import Unknown, reproduce_unknown

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
# The help of the command does not need torch.
__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "Comparison": "contenders",
        "RealObjects": "real",
        "RobotScans": "robot_answers",
        "Table2": "table2",
        "Unknown": "unknown",
        "reproduce_real": "real",
        "reproduce_rivals": "rivals",
        "reproduce_robot": "table2_robot",
        "reproduce_robustness": "robustness",
        "reproduce_table2": "table2",
        "reproduce_unknown": "unknown",
    },
)
