"""Why there is no plan, in words that a person can act on."""

from collections.abc import Callable, Sequence

from kabo.geometry_server.answers import Failure
from kabo.knowledge import GroundedTask, Verdict, unreachable_goals
from kabo.language.formulas import GroundCall
from kabo.language.problem import Problem
from kabo.planner.proofs.dead_ends import dead_ends
from kabo.planner.proofs.refused_calls import refused
from kabo.planner.proofs.unreachable import SAME_REASONS, unreachable_because
from kabo.planner.proofs.wording import listed
from kabo.planner.result import Reason

SHOWN = 12  # refusals that are told
EXPLAINED = 6  # sentences about what can never be known

BEYOND = (
    "not on the knowledge level: as far as kabo's knowledge goes everything was tried, but kabo does not reason by "
    "cases, and here a plan may need to"
)

_SPENT = {
    "expansions": "the search has expanded as many nodes as allowed",
    "samples": "procedures were refused, and more samples might help",
    "time": "the time is up",
    "interrupted": "the run was interrupted",
    "memory": "the run holds as much memory as allowed",
}


def no_plan(
    problem: Problem,
    task: GroundedTask,
    failures: Sequence[tuple[GroundCall, Failure]],
    deadline: Callable[[], bool] | None = None,
) -> Reason:
    """Proven: the goal is beyond what actions can bring about, or every refusal is a proof."""
    if not failures:
        return _beyond(problem) if unreachable_goals(task) else _dead_end(task, deadline)
    text = "no plan reaches the goal: every procedure that was refused was refused by a proof"
    return Reason("refusals", None, text, _told(failures))


def _beyond(problem: Problem) -> Reason:
    """Some parts of the goal never hold, even if nothing were ever lost."""
    goals = unreachable_because(problem)
    told = [sentence for goal in goals for sentence in goal.why if not sentence.startswith(SAME_REASONS)]
    few = told if len(told) <= EXPLAINED else [*told[:EXPLAINED], "kabo explain says more"]
    names = listed((goal.text for goal in goals), "and")
    text = f"no plan reaches the goal, whatever geometry says: {names} can never hold, whatever is done"
    return Reason("knowledge", None, text, tuple(few))


def _dead_end(task: GroundedTask, deadline: Callable[[], bool] | None) -> Reason:
    """All parts of the goal could hold if nothing were ever lost."""
    text = (
        "no plan reaches the goal, whatever geometry says: every part of it could hold if nothing that is known were "
        "ever lost, but every way ends in a dead end"
    )
    return Reason("knowledge", None, text, tuple(dead_ends(task, deadline)))


def beyond_reasoning(verdict: Verdict, failures: Sequence[tuple[GroundCall, Failure]] = ()) -> Reason | None:
    """Not proven although everything was tried: knowledge is not complete here; None if it is, and that is a proof.

    The details name what makes it so, each with its place.
    """
    if verdict.is_proof:
        return None
    told = [str(gap) for gap in verdict.gaps[:EXPLAINED]]
    if len(verdict.gaps) > EXPLAINED:
        told.append(f"… and {len(verdict.gaps) - EXPLAINED} more")
    return Reason(None, "reasoning", BEYOND, (*told, *_told(failures)))


def exhausted(budget: str, failures: Sequence[tuple[GroundCall, Failure]], why: str | None = None) -> Reason:
    """Not proven: what ran out (`why`, if that says it better), and what stood in the way until then."""
    return Reason(None, budget, f"no plan was found: {_SPENT[why or budget]}", _told(failures))  # type: ignore[arg-type]


def _telling(item: tuple[GroundCall, Failure]) -> tuple[bool, int]:
    """What was refused after many attempts says more than what was known to be out of reach from the start."""
    return item[1].proof, -item[1].attempts


def _told(failures: Sequence[tuple[GroundCall, Failure]]) -> tuple[str, ...]:
    ordered = sorted(failures, key=_telling)
    told = [refused(call, failure) for call, failure in ordered[:SHOWN]]
    if len(failures) > SHOWN:
        told.append(f"… and {len(failures) - SHOWN} more")
    return tuple(told)
