"""The result of planning: a plan, a proof that there is none, or the budget that ended the search.

All three are results, not errors. `result_to_json` makes the JSON object (schema `kabo-result-1`,
docs/reference/plans.md#the-result) that both `kabo solve --json` and the service return.
"""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal

from kabo.budgets import Spent
from kabo.errors import Diagnostic, InputError
from kabo.plan import Plan, plan_hash, plan_statistics

Status = Literal["solved", "no_plan", "exhausted"]

# Every figure of `statistics` but those of the plan itself; a figure that nobody counted is zero.
COUNTS = (
    "collision_checks",
    "expanded",
    "generated",
    "geometric_states",
    "inverse_kinematics_calls",
    "pair_checks",
    "positive_collision_checks",
)
PLAN_FIGURES = ("plan_actions", "plan_leaves", "plan_nodes", "waypoints")
REFINED = ("path_length_found", "path_length", "duration_found", "duration", "overlap", "refine_s")
SECONDS = ("collision_s", "geometric_s", "load_s", "symbolic_s", "total_s")


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
    that is spent of the budget of expansions, samples or time, of that which is spent most; None if there is none.
    """

    doing: str
    expanded: int = 0
    generated: int = 0
    procedure_calls: int = 0
    fraction: float | None = None
    line: str = ""
    spent: float | None = None


@dataclass(frozen=True)
class Result:
    """The outcome of planning: `plan` is set if the status is "solved", `reason` otherwise."""

    status: Status
    plan: Plan | None
    statistics: Mapping[str, Any] = field(default_factory=dict)
    reason: Reason | None = None
    cut_off: tuple[str, ...] = ()  # what the plan lacks because time or memory was spent after it was found


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
    message = f"{_count(len(found), 'problem')} in {_count(files, 'file')}"
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
    known = result.statistics
    figures: dict[str, Any] = {name: int(known.get(name, 0)) for name in COUNTS}
    figures |= {name: round(float(known.get(name, 0.0)), 6) for name in SECONDS}
    figures |= {name: round(float(known[name]), 6) for name in REFINED if name in known}
    figures["procedures"] = {
        name: {"calls": int(row["calls"]), "failures": dict(row["failures"])}
        for name, row in known.get("procedures", {}).items()
    }
    plan = dict.fromkeys(PLAN_FIGURES) if result.plan is None else asdict(plan_statistics(result.plan))
    return figures | plan


def _reason(reason: Reason) -> dict[str, Any]:
    written: dict[str, Any] = {"proved": reason.proved, "message": reason.message, "details": list(reason.details)}
    return written if reason.budget is None else written | {"budget": reason.budget}


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"
