"""Why there is no plan, in words that a person can act on."""

from collections.abc import Sequence

from kabo.geometry_server.answers import Failure
from kabo.knowledge import Task, unreachable_goals
from kabo.language.formulas import GroundCall
from kabo.planner.result import Reason

SHOWN = 12  # refusals that are told

_SPENT = {
    "expansions": "the search has expanded as many nodes as allowed",
    "samples": "procedures were refused, and more samples might help",
    "time": "the time is up",
}


def no_plan(task: Task, failures: Sequence[tuple[GroundCall, Failure]]) -> Reason:
    """Proven: the goal is beyond what actions can bring about, or every refusal is a proof."""
    if not failures:
        goals = unreachable_goals(task)
        details = tuple(f"never reached: {goal}" for goal in goals)
        which = f"; {len(goals)} of its parts never hold, whatever is done" if goals else ""
        return Reason("knowledge", None, f"no plan reaches the goal, whatever geometry says{which}", details)
    text = "no plan reaches the goal: every procedure that was refused was refused by a proof"
    return Reason("refusals", None, text, _told(failures))


def exhausted(budget: str, failures: Sequence[tuple[GroundCall, Failure]]) -> Reason:
    """Not proven: what ran out, and what stood in the way until then."""
    return Reason(None, budget, f"no plan was found: {_SPENT[budget]}", _told(failures))  # type: ignore[arg-type]


def _told(failures: Sequence[tuple[GroundCall, Failure]]) -> tuple[str, ...]:
    told = [f"{call}: {failure.message}" for call, failure in failures[:SHOWN]]
    if len(failures) > SHOWN:
        told.append(f"… and {len(failures) - SHOWN} more")
    return tuple(told)
