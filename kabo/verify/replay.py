"""Replays the plan on the knowledge level: preconditions, sensing, complete branches, and the goal at every leaf.

Nodes are taken in topological order with the *set* of knowledge states that can arrive there; states that agree on
all that the continuation asks for are one. So a plan for 2^n outcomes costs about its nodes, not its branches.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from kabo.language.problem import Problem
from kabo.plan import Node, Plan
from kabo.verify.arguments import check_calls
from kabo.verify.draft import ContradictionError
from kabo.verify.ground import NotVerifiableError
from kabo.verify.interpreter import Interpreter
from kabo.verify.knowledge import Frozen, Knowledge
from kabo.verify.relevance import Relevance, forget
from kabo.verify.report import Finding
from kabo.verify.steps import mentioned, step


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
    relevance = relevance_of(plan, order, interpreter)
    arriving: dict[str, dict[Frozen, Knowledge]] = {name: {} for name in order}
    _arrive(arriving[plan.root], forget(start, relevance.kept(plan.root)))
    for name in order:
        node = plan.nodes[name]
        told: dict[str, None] = {}
        kept = {successor: relevance.kept(successor) for successor in node.successors if successor in arriving}
        for state in arriving.pop(name).values():
            result.states += 1
            played = step(interpreter, node, state)
            told.update(dict.fromkeys(played.messages))
            for way in played.ways:
                if way.successor in arriving:
                    _arrive(arriving[way.successor], forget(way.state, kept[way.successor]))
        result.findings.extend(Finding(name, message) for message in told)
    return result


def _arrive(states: dict[Frozen, Knowledge], state: Knowledge) -> None:
    states.setdefault(state.frozen(), state)


def relevance_of(plan: Plan, order: Sequence[str], interpreter: Interpreter) -> Relevance:
    """What the rest of a plan can ask for at each of its nodes."""
    cache: dict[object, tuple[object, ...]] = {}

    def asked(node: Node) -> Iterator[object]:
        key = node.kind, node.action, tuple(sorted(node.arguments.items())), node.on, node.delivers
        if key not in cache:
            cache[key] = tuple(dict.fromkeys(mentioned(node, interpreter)))
        return iter(cache[key])

    return Relevance(plan, order, asked, interpreter.rules.mentioned)  # type: ignore[arg-type]
