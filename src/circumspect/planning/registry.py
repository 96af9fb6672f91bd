"""Registry of view planners."""

from __future__ import annotations

from typing import Any

from circumspect.errors import CircumspectError, InputError
from circumspect.planning.circle_planner import CirclePlanner
from circumspect.planning.confidence_planner import ConfidencePlanner
from circumspect.planning.surface_normal_planner import SurfaceNormalPlanner
from circumspect.planning.view_planner import ViewPlanner
from circumspect.plugins import PluginError, Registry, cause_of, kind_of

PLANNERS: dict[str, type[ViewPlanner]] = {
    "normals": SurfaceNormalPlanner,
    "circle": CirclePlanner,
    "confidence": ConfidencePlanner,
}
"""Built-in planners; the first is the default."""


def _checked(name: str, value: Any) -> type[ViewPlanner]:  # noqa: ARG001
    if not isinstance(value, type) or not issubclass(value, ViewPlanner):
        raise InputError(
            f"{kind_of(value)}; a subclass of circumspect.planning.ViewPlanner is needed"
        )
    return value


PLANNER_REGISTRY = Registry("view planner", "circumspect.planners", PLANNERS, _checked)
"""Built-in planners and those of other packages."""


def make_planner(name: str) -> ViewPlanner:
    """Create a planner with its default settings.

    Args:
        name: One of `PLANNERS`, an entry point of the group `circumspect.planners`, or MODULE:NAME
            of a subclass of `ViewPlanner`.

    Raises:
        InputError: There is no planner of that name.
        PluginError: The planner cannot be created.
    """
    kind = PLANNER_REGISTRY.get(name)
    try:
        return kind()
    except CircumspectError:
        raise
    # An abstract class, one that requires arguments, or foreign code that fails.
    except Exception as error:
        raise PluginError(f"view planner '{name}' can not be made: {cause_of(error)}") from error
