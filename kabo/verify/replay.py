"""Replays the plan on the knowledge level: preconditions, sensing, complete branches, and the goal at every leaf.

Nodes are taken in topological order with the *set* of knowledge states that can arrive there; states that agree on
all that the continuation asks for are one. So a plan for 2^n outcomes costs about its nodes, not its branches.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.verify.arguments import check_calls
from kabo.verify.draft import ContradictionError
from kabo.verify.ground import NotVerifiableError
from kabo.verify.interpreter import Interpreter
from kabo.verify.knowledge import Frozen, Knowledge
from kabo.verify.relevance import Relevance
from kabo.verify.report import Finding
from kabo.verify.steps import step, unmet_early

MOST_STATES = 200_000  # different ones; a plan of 25,000 nodes has about as many
TOO_MANY = f"more than {MOST_STATES} different states of knowledge arise up to here: the rest was not judged"


@dataclass
class Replay:
    """The outcome: findings, and how many knowledge states were looked at."""

    findings: list[Finding] = field(default_factory=list)
    states: int = 0


def replay(plan: Plan, problem: Problem, order: Sequence[str]) -> Replay:
    """Replays all branches of a plan whose nodes are given, each before its successors."""
    result = Replay()
    result.findings.extend(check_calls(plan, order, problem))
    if result.findings:
        return result
    try:
        interpreter = Interpreter(problem)
        start = interpreter.initial()
    except (NotVerifiableError, ContradictionError) as error:
        result.findings.append(Finding(None, f"the initial knowledge: {error}"))
        return result
    relevance = Relevance(plan, order, interpreter)
    arriving: dict[str, dict[Frozen, Knowledge]] = {name: {} for name in order}
    _arrive(arriving[plan.root], relevance.reduced(plan.root, start))
    for name in order:
        if result.states > MOST_STATES:
            result.findings.append(Finding(name, TOO_MANY))
            return result
        told: dict[str, None] = {}
        early = [
            after for after in plan.nodes[name].successors if after in arriving and plan.nodes[after].overlap > 0.0
        ]
        before: dict[tuple[str, str], None] = {}
        for state in arriving.pop(name).values():
            result.states += 1
            played = step(interpreter, plan.nodes[name], state)
            told.update(dict.fromkeys(played.messages))
            for after in early:
                wrong = unmet_early(interpreter, plan.nodes[after], state)
                before.update(dict.fromkeys((after, message) for message in wrong))
            for way in played.ways:
                if way.successor in arriving:
                    _arrive(arriving[way.successor], relevance.reduced(way.successor, way.state))
        relevance.leave(name)
        result.findings.extend(Finding(name, message) for message in told)
        result.findings.extend(Finding(after, message) for after, message in before)
    return result


def _arrive(states: dict[Frozen, Knowledge], state: Knowledge) -> None:
    states.setdefault(state.frozen(), state)
