"""A plan in the view document."""

from typing import TYPE_CHECKING

from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import View

if TYPE_CHECKING:
    from kabo.language.problem import Problem
    from kabo.plan import Plan
    from kabo.scene import Scene


def plan_view(plan: "Plan", problem: "Problem", scene: "Scene | None", arrays: Arrays) -> View | None:
    """The part `plan` of a view document; None: nothing of it is shown yet."""
    return None
