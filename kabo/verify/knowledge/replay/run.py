"""Replays the plan on the knowledge level: preconditions, sensing, complete branches, and the goal at every leaf.

Nodes are taken in topological order with the *set* of knowledge states that can arrive there; states that agree on
all that the continuation reads are merged. So the work for 2^n outcomes grows with the number of nodes, not of
branches.

Where more knowledge never hurts, all states that arrive at a node are merged into one, which knows what they all know.
If a condition fails for a merged state, states are kept separate for the last steps before the node, for more and more
of them; if that does not help, all states are examined one by one.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.verify.knowledge.arguments import check_calls
from kabo.verify.knowledge.ground import NotVerifiableError
from kabo.verify.knowledge.past import is_past
from kabo.verify.knowledge.replay.interpreter import Interpreter
from kabo.verify.knowledge.replay.merging import meet, more_never_hurts
from kabo.verify.knowledge.replay.mutable_knowledge import ContradictionError
from kabo.verify.knowledge.replay.relevance import Relevance
from kabo.verify.knowledge.replay.states import Frozen, Knowledge
from kabo.verify.knowledge.replay.steps import Way, step, unmet_early
from kabo.verify.report import Finding

MAX_STATES = 200_000  # different states of knowledge; a plan of 25,000 nodes has about as many
MAX_REMEMBERED_NODES = 2000  # nodes whose separate states are kept
SEPARATED_STEPS = (
    4,
    8,
    16,
    32,
)  # for so many steps before a node states are looked at one by one, before they all are
TOO_MANY = f"more than {MAX_STATES} different states of knowledge arise up to here: the rest was not judged"


@dataclass
class Replay:
    """The outcome of a replay: findings, and the number of examined knowledge states."""

    findings: list[Finding] = field(default_factory=list)
    states: int = 0


def replay(plan: Plan, problem: Problem, order: Sequence[str]) -> Replay:
    """Replays all branches of a plan; `order` lists its nodes in topological order."""
    findings = list(check_calls(plan, order, problem))
    if findings:
        return Replay(findings)
    try:
        interpreter = Interpreter(problem)
        start = interpreter.initial()
    except (NotVerifiableError, ContradictionError) as error:
        return Replay([Finding(None, f"the initial knowledge: {error}")])
    run = _ReplayRun(plan, order, interpreter, start)
    result = run.at_once() if more_never_hurts(problem) else None
    return run.one_by_one() if result is None else result


class _ReplayRun:
    """All replays of one plan."""

    def __init__(self, plan: Plan, order: Sequence[str], interpreter: Interpreter, start: Knowledge) -> None:
        self.plan, self.order, self.interpreter = plan, order, interpreter
        self.relevance = Relevance(plan, order, interpreter)
        self.start = self.relevance.reduced(plan.root, start)

    # ------------------------------------------------------------------------------------------------ one by one
    def one_by_one(self) -> Replay:
        """Examines all states that differ in what the rest of the plan reads."""
        result = Replay()
        arriving: dict[str, dict[Frozen, Knowledge]] = {name: {} for name in self.order}
        arriving[self.plan.root][self.start.frozen()] = self.start
        for name in self.order:
            if result.states > MAX_STATES:
                result.findings.append(Finding(name, TOO_MANY))
                return result
            states = arriving.pop(name).values()
            result.states += len(states)
            findings, ways = self._played(name, states)
            result.findings.extend(findings)
            for way in ways:
                if way.successor in arriving:
                    state = self.relevance.reduced(way.successor, way.state)
                    arriving[way.successor].setdefault(state.frozen(), state)
            self.relevance.leave(name)
        return result

    def _played(self, name: str, states: Iterable[Knowledge]) -> tuple[list[Finding], list[Way]]:
        """The faults of a node in these states, and the ways on from it."""
        nodes = self.plan.nodes
        early = [after for after in nodes[name].successors if after in nodes and nodes[after].overlap > 0.0]
        told: dict[str, None] = {}
        before: dict[tuple[str, str], None] = {}
        ways: list[Way] = []
        for state in states:
            played = step(self.interpreter, nodes[name], state, every=not is_past(name))
            told.update(dict.fromkeys(played.messages))
            for after in early:
                wrong = unmet_early(self.interpreter, nodes[after], state)
                before.update(dict.fromkeys((after, message) for message in wrong))
            ways += played.ways
        return [Finding(name, message) for message in told] + [Finding(*each) for each in before], ways

    # -------------------------------------------------------------------------------------------------- at once
    def at_once(self) -> Replay | None:
        """Merges the states that arrive at a node; None if a condition fails, which need not be the plan's fault."""
        result = Replay()
        arriving = {self.plan.root: self.start}
        played: dict[str, list[Knowledge]] = {}
        for name in self.order:
            played[name] = [arriving.pop(name)] if name in arriving else []
            if len(played) > MAX_REMEMBERED_NODES:
                del played[next(iter(played))]
            findings, ways = self._played(name, played[name])
            for far in SEPARATED_STEPS if findings else ():
                played[name] = self._apart(name, far, played, {})
                findings, ways = self._played(name, played[name])
                if not findings:
                    break
            if findings:
                return None
            result.states += len(played[name])
            for way in ways:
                state, other = way.state, arriving.get(way.successor)
                arriving[way.successor] = (
                    state if other is None else meet(other, state, self.start, self.interpreter.problem)
                )
        return result

    @cached_property
    def _before(self) -> dict[str, list[str]]:
        """The predecessors of each node."""
        before: dict[str, list[str]] = {name: [] for name in self.order}
        for name in self.order:
            for successor in dict.fromkeys(self.plan.nodes[name].successors):
                if successor in before:
                    before[successor].append(name)
        return before

    def _apart(
        self,
        name: str,
        far: int,
        played: Mapping[str, list[Knowledge]],
        known: dict[tuple[str, int], list[Knowledge]],
    ) -> list[Knowledge]:
        """The separate states that arrive at a node, from the merged ones in `played` at nodes `far` steps before it."""
        if far == 0 or name == self.plan.root or any(before not in played for before in self._before[name]):
            return played[name]
        if (name, far) not in known:
            found: dict[Frozen, Knowledge] = {}
            for before in self._before[name]:
                for way in self._played(before, self._apart(before, far - 1, played, known))[1]:
                    if way.successor == name:
                        found.setdefault(way.state.frozen(), way.state)
            known[name, far] = list(found.values())
        return known[name, far]
