"""The reasons why there is no plan, as sentences for users."""

from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import replace

from kabo.geometry_server.answers import Refusal
from kabo.knowledge import GroundedTask, Verdict, ground, unreachable_goals
from kabo.language.formulas import GroundCall
from kabo.language.problem import Problem
from kabo.plan import State
from kabo.planner.continuing import knowledge_after
from kabo.planner.proofs.refused_calls import refused
from kabo.planner.proofs.wording import listed
from kabo.planner.result import Reason

SHOWN_REFUSALS = 12  # refused calls that a reason lists
SHOWN_SENTENCES = 6  # sentences about what can never be known that a reason lists

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
    failures: Sequence[tuple[GroundCall, Refusal]],
    deadline: Callable[[], bool] | None = None,
    *,
    begun: State | None = None,
) -> Reason:
    """The reason why there is provably no plan: no action can reach the goal, or every refusal is a proof.

    `begun`: the state of a run in which the task begins; None: it begins where the problem does.
    """
    if not failures:
        goals = unreachable_goals(task)
        if goals and begun is not None:
            text = (
                f"no plan reaches the goal, whatever geometry says: {listed(goals, 'and')} can never hold any more"
            )
            return Reason("knowledge", None, text, tuple(_since(problem, goals, begun)))
        return _beyond(problem) if goals else _dead_end(task, deadline)
    text = "no plan reaches the goal: every procedure that was refused was refused by a proof"
    return Reason("refusals", None, text, _listed(failures))


def _since(problem: Problem, goals: Sequence[str], begun: State) -> Iterator[str]:
    """What of all that was done and observed has put each conjunct of the goal out of reach, in a sentence."""
    happened = any(step.action in problem.domain.events for step in begun.done)
    task, missing = ground(problem.with_events() if happened else problem), list(goals)
    planned = tuple(action for action in task.actions if action.name not in problem.domain.events)
    for number in range(len(begun.done), 0, -1):
        before = replace(task, initial=knowledge_after(task, begun.done[: number - 1]), actions=planned)
        lost = set(missing) - set(unreachable_goals(before))
        step = begun.done[number - 1]
        what = [] if step.action is None else [f"{step.action}({', '.join(map(str, step.arguments.values()))})"]
        what += [] if step.on is None else [f"{step.on} was found to be {step.outcome}"]
        yield from (
            f"{goal} was in reach until step {number}: {', '.join(what)}" for goal in missing if goal in lost
        )
        missing = [goal for goal in missing if goal not in lost]
        if not missing:
            return


def _beyond(problem: Problem) -> Reason:
    """Some conjuncts of the goal never hold, even under delete relaxation."""
    # Loaded here, as below, since a problem with a plan needs no proof that there is none.
    from kabo.planner.proofs.unreachable import SAME_REASONS, unreachable_because

    goals = unreachable_because(problem)
    sentences = [sentence for goal in goals for sentence in goal.why if not sentence.startswith(SAME_REASONS)]
    few = (
        sentences
        if len(sentences) <= SHOWN_SENTENCES
        else [*sentences[:SHOWN_SENTENCES], "kabo explain says more"]
    )
    names = listed((goal.text for goal in goals), "and")
    text = f"no plan reaches the goal, whatever geometry says: {names} can never hold, whatever is done"
    return Reason("knowledge", None, text, tuple(few))


def _dead_end(task: GroundedTask, deadline: Callable[[], bool] | None) -> Reason:
    """All conjuncts of the goal hold under delete relaxation."""
    from kabo.planner.proofs.dead_ends import dead_ends  # as above

    text = (
        "no plan reaches the goal, whatever geometry says: every part of it could hold if nothing that is known were "
        "ever lost, but every way ends in a dead end"
    )
    return Reason("knowledge", None, text, tuple(dead_ends(task, deadline)))


def beyond_reasoning(verdict: Verdict, failures: Sequence[tuple[GroundCall, Refusal]] = ()) -> Reason | None:
    """The reason that kabo's reasoning is incomplete although everything was tried; None if it is complete.

    If it is complete, a search that tried everything is a proof. The details of the reason name the constructs
    that make the reasoning incomplete, each with its place in the file.
    """
    if verdict.is_proof:
        return None
    sentences = [str(gap) for gap in verdict.gaps[:SHOWN_SENTENCES]]
    if len(verdict.gaps) > SHOWN_SENTENCES:
        sentences.append(f"… and {len(verdict.gaps) - SHOWN_SENTENCES} more")
    return Reason(None, "reasoning", BEYOND, (*sentences, *_listed(failures)))


def exhausted(
    budget: str,
    failures: Sequence[tuple[GroundCall, Refusal]],
    why: str | None = None,
    needed: Container[GroundCall] = (),
) -> Reason:
    """The reason that a budget was spent, with the calls that were refused until then.

    Args:
        budget: the name of the budget.
        failures: the refused calls, each with one refusal.
        why: a more specific cause for the message, such as an interruption; by default the name of the budget.
        needed: the calls that every plan needs; they are told first.
    """
    listed = _listed(failures, needed)
    return Reason(None, budget, f"no plan was found: {_SPENT[why or budget]}", listed)  # type: ignore[arg-type]


def _verbosity(item: tuple[GroundCall, Refusal]) -> tuple[bool, bool, int]:
    """The order in which refused calls are listed: what one option decides first, then many attempts, proofs last."""
    refusal = item[1]
    decided = any(measure.decides_alone for measure in refusal.measures)
    return not decided, refusal.proof, -refusal.attempts


def _listed(failures: Sequence[tuple[GroundCall, Refusal]], needed: Container[GroundCall] = ()) -> tuple[str, ...]:
    ordered = sorted(failures, key=lambda item: (item[0] not in needed, *_verbosity(item)))
    sentences = [refused(call, failure) for call, failure in ordered[:SHOWN_REFUSALS]]
    if len(failures) > SHOWN_REFUSALS:
        sentences.append(f"… and {len(failures) - SHOWN_REFUSALS} more")
    return tuple(sentences)
