"""The result of planning: a plan, a proof that there is none, or the budget that ended the search.

All three are results, not errors. `result_to_json` makes the JSON object (schema `kabo-result-1`,
docs/reference/plans.md#the-result) that both `kabo solve --json` and the service return.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from kabo.budgets import Spent
from kabo.displays import bullets, counted, display
from kabo.errors import Diagnostic, InputError
from kabo.language.problem import Problem
from kabo.plan import Plan, plan_hash
from kabo.plan.plan import summary
from kabo.planner.statistics import PYTHON_ONLY, Statistics, completed

Status = Literal["solved", "no_plan", "exhausted"]


@dataclass(frozen=True)
class Reason:
    """The reason why there is no plan.

    `proved`: `knowledge` (the goal is unreachable whatever geometry says), `refusals` (every refusal is a proof),
    or None. `budget`: the budget that was spent if nothing is proved; `reasoning` means that everything was tried,
    but a plan may need reasoning by cases, which kabo does not do; `so_far` that the run goes on. `message`: one
    sentence. `details`: further sentences.
    """

    proved: Literal["knowledge", "refusals"] | None
    budget: Spent | Literal["reasoning", "so_far"] | None
    message: str
    details: tuple[str, ...] = ()

    def with_details(self, details: Iterable[str]) -> "Reason":
        """This reason with further sentences."""
        return replace(self, details=(*self.details, *details))


@dataclass(frozen=True)
class Progress:
    """The progress of planning, sent periodically; it is never part of a result.

    `doing`: the present step in two or three words. `fraction`: the share that is done (0 to 1); None if the total
    is unknown. `line`: what was just done, if it is worth a line of its own that stays; else empty. `spent`: the share
    that is spent of the budget of expansions or of samples, of that which is spent more. `seconds_left`: of the budget
    of time; None if it has no limit. `refused`: the call that was refused most until now, how often, and by what;
    empty if none was.
    """

    doing: str
    expanded: int = 0
    generated: int = 0
    procedure_calls: int = 0
    fraction: float | None = None
    line: str = ""
    spent: float | None = None
    seconds_left: float | None = None
    refused: str = ""


@dataclass(frozen=True)
class Result:
    """The outcome of planning: `plan` is set if the status is "solved", `reason` otherwise.

    Attributes:
        status: `solved`; `no_plan`, which is proven; or `exhausted`: a budget was spent.
        plan: the plan, or None.
        statistics: the figures of the run by name, such as `result.statistics["expanded"]`.
        reason: why there is no plan, or None.
        cut_off: what the plan lacks because time or memory was spent after it was found.
        problem: what was solved, for whoever shows the plan in its scene; None if it is not known.
    """

    status: Status
    plan: Plan | None
    statistics: Statistics = field(default_factory=lambda: completed({}))
    reason: Reason | None = None
    cut_off: tuple[str, ...] = ()
    problem: Problem | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "statistics", completed(self.statistics, self.plan))

    def __repr__(self) -> str:
        return f"<Result {self.status}: {self._outcome()}>"

    def _repr_html_(self) -> str:
        figures = self.statistics
        calls = sum(row["calls"] for row in figures["procedures"].values())
        rows = {
            "why" if self.plan is None else "outcome": self._outcome(),
            "seconds": f"{figures['total_s']:.1f} in all, {figures['symbolic_s']:.1f} on the knowledge level, "
            f"{figures['geometric_s']:.1f} of geometry",
            "search": f"{figures['expanded']} states expanded, {figures['generated']} generated",
            "geometry": f"{calls} calls, {figures['collision_checks']} collision checks" if calls else "",
            "lacks": "; ".join(self.cut_off),
        }
        details = bullets(() if self.reason is None else self.reason.details)
        return display(f"Result: {self.status}", rows, self if self.plan is not None else None) + details

    def _outcome(self) -> str:
        if self.plan is not None:
            return summary(self.plan)
        return "no plan" if self.reason is None else self.reason.message


def result_to_json(
    result: Result, plan_path: str | None = None, diagnostics: Iterable[Diagnostic] = ()
) -> dict[str, Any]:
    """The result as a JSON object of the schema `kabo-result-1`.

    Args:
        result: the result of planning.
        plan_path: the path of the plan file; None if none was written.
        diagnostics: warnings about the problem, which is valid nevertheless.
    """
    body: dict[str, Any] = {
        "status": result.status,
        "plan": plan_path if result.plan is not None else None,
        "plan_hash": None if result.plan is None else plan_hash(result.plan),
        "statistics": _statistics(result),
        "reason": None if result.reason is None else _reason(result.reason),
        "diagnostics": [diagnostic_to_json(diagnostic) for diagnostic in diagnostics],
    }
    return body | {"cut_off": list(result.cut_off)} if result.cut_off else body


def invalid_to_json(error: InputError) -> dict[str, Any]:
    """The JSON object for a problem that cannot be read: status "invalid", with every diagnostic."""
    found = error.diagnostics
    files = len({diagnostic.file for diagnostic in found})
    message = f"{counted(len(found), 'problem')} in {counted(files, 'file')}"
    return {
        "status": "invalid",
        "plan": None,
        "plan_hash": None,
        "statistics": None,
        "reason": {"proved": None, "message": message, "details": []},
        "diagnostics": [diagnostic_to_json(diagnostic) for diagnostic in found],
    }


def diagnostic_to_json(diagnostic: Diagnostic) -> dict[str, Any]:
    """A diagnostic as a JSON object; the keys are those of the result schema."""
    names = ("severity", "file", "line", "column", "length", "message", "hint")
    return {name: getattr(diagnostic, name) for name in names}


def _statistics(result: Result) -> dict[str, Any]:
    """The figures in the form of the schema: times and lengths are rounded to 1e-6."""
    return {
        name: round(value, 6) if isinstance(value, float) else value
        for name, value in result.statistics.items()
        if name not in PYTHON_ONLY
    }


def _reason(reason: Reason) -> dict[str, Any]:
    written: dict[str, Any] = {"proved": reason.proved, "message": reason.message, "details": list(reason.details)}
    return written if reason.budget is None else written | {"budget": reason.budget}
