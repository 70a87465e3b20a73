"""The verifier: leads a plan through all possible worlds, and re-proves every motion and its certificate.

It shares no code with the planner: it knows the problem's language, the plan, the scene, pinocchio and coal, and
judges with dictionaries and sets, and with the original triangle meshes. What is wrong is a finding with its node.
"""

import sys
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any

from kabo.verify.report import Finding, Least, Report, WorldReport

if TYPE_CHECKING:
    from kabo.language import Problem
    from kabo.plan import Plan
    from kabo.verify.knowledge import validate_worlds
    from kabo.verify.verification import verify_plan

__all__ = ["Finding", "Least", "Report", "WorldReport", "validate_worlds", "verify_plan"]


def __getattr__(name: str) -> Any:
    if name == "verify_plan":
        from kabo.verify.verification import verify_plan

        return verify_plan
    if name == "validate_worlds":
        from kabo.verify.knowledge import validate_worlds

        return validate_worlds
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


class _Room(ModuleType):
    """`kabo.verify` is this room and, as the façade promises, also the function."""

    def __call__(
        self,
        problem: "Problem",
        plan: "Plan",
        *,
        knowledge_only: bool = False,
        procedures: "Mapping[str, Callable[..., Any]] | None" = None,
        paranoid: bool = False,
    ) -> Report:
        """As `verify_plan`."""
        from kabo.verify.verification import verify_plan

        return verify_plan(problem, plan, knowledge_only=knowledge_only, procedures=procedures, paranoid=paranoid)


sys.modules[__name__].__class__ = _Room
