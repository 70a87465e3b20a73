"""The nodes of the search: pairs of a knowledge state and a trace, which identifies the geometric state.

A trace says which procedure calls made the present values of the geometric components.
"""

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from kabo.knowledge import Branching, GeometricOracle, GroundAction, GroundedTask, optimistic
from kabo.knowledge.facts import open_entries
from kabo.knowledge.queries import Query, bits_of, conjunction, split, union
from kabo.language.formulas import GroundCall
from kabo.planner.search.heuristics import DEFAULT_HEURISTIC, HEURISTICS, Heuristic
from kabo.planner.search.skeleton import Geometry, Trace

Node = tuple[int, Trace]
Move = tuple[GroundAction, int, Node]  # an action, which attempt of its procedure, and the node after it


class Act(NamedTuple):
    """A step of a weak plan: an action, the index of the attempt at its procedure call, and the trace after it.

    A trace says which calls made the present values of the geometric components.
    """

    action: GroundAction
    attempt: int
    trace: Trace


class Assume(NamedTuple):
    """A step of a weak plan that assumes one outcome of a branching."""

    branching: Branching
    outcome: str


Step = Act | Assume


_Indexed = tuple[int, int, int, Query | None, GroundAction, Callable[..., int | None]]


class SearchSpace:
    """The search graph of a task with its geometry; without geometry, every procedure call succeeds."""

    def __init__(
        self,
        task: GroundedTask,
        geometry: Geometry | None,
        may_wait: bool = False,
        assume_last: bool = True,
        heuristic: str = DEFAULT_HEURISTIC,
    ) -> None:
        """Nothing is computed yet.

        Args:
            task: the grounded problem.
            geometry: what it takes into account of geometry.
            may_wait: whether what was sensed may stay open; else it is branched on at once.
            assume_last: whether weak plans assume the last outcome of sensing first, in plan order; else the first.
            heuristic: a key of `HEURISTICS`.
        """
        self.task, self.geometry = task, geometry
        self.may_wait, self.assume_last, self._heuristic = may_wait, assume_last, heuristic
        self.start: Node = (task.initial, None if geometry is None else geometry.start)
        self._reduced, self._form = task.relevance.reduced, task.normal_form.of
        self._together: dict[tuple[int, ...], Query] = {}  # conjuncts of the goal as one query
        self._entries: list[_Indexed] = []
        self._by_bit: dict[int, list[_Indexed]] = {}
        for action in task.actions:
            mask, value, rest = split(action.precondition)
            telling = value & task.functional or value & ~task.initial or value
            entry = (action.index, mask, value, rest, action, action.after)
            self._by_bit.setdefault(_rarest(telling, self._by_bit), []).append(entry)
            self._entries.append(entry)
        self._indexed = union(self._by_bit)

    @cached_property
    def heuristic(self) -> Heuristic:
        """The heuristic of the task without the refused calls, created at the first use."""
        refused = frozenset[GroundCall]() if self.geometry is None else self.geometry.refused_everywhere()[0]
        return HEURISTICS[self._heuristic](self.task, refused)

    def key(self, node: Node) -> Hashable:
        """The key of a node; nodes with equal keys have the same plans."""
        state = self._form(self._reduced(node[0]))
        return state if self.geometry is None else (state, self.geometry.key(node[1]))

    def known(self, node: Node) -> int:
        """The knowledge state of a node in normal form; nodes that differ only in geometry have the same."""
        return self._form(self._reduced(node[0]))

    def confirmed_key(self, node: Node) -> Hashable | None:
        """The key of a node after its pending procedure calls were made; None if one is refused.

        It is called when a node is about to be expanded or to end a search.
        """
        return self.key(node) if self.geometry is None or self.geometry.confirm(node[1]) else None

    def oracle(self, trace: Trace) -> GeometricOracle:
        """The oracle that answers the geometric tests inside formulas for a trace."""
        return optimistic if self.geometry is None else _Oracle(self.geometry, trace)

    def is_goal(self, node: Node) -> bool:
        """Whether the goal holds at a node, whatever the outcomes of sensing that are not yet branched on.

        An exclusive-or of queries may hold only until an open outcome is branched on, so all outcomes are checked
        [K Table 6.1: a full bottle must not be washed]. Where branching may be postponed, only the present state
        is tested.
        """
        if not self.task.is_goal(node[0], self.oracle(node[1])):
            return False
        if self.may_wait or not open_entries(node[0], self.task.pending):
            return True
        branching = self.task.open_branching(node[0])
        return branching is None or all(self.is_goal(child) for _, child in self.outcomes(node, branching))

    def holds(self, parts: tuple[int, ...], node: Node) -> bool:
        """Whether the goal conjuncts with the indices `parts` hold at a node."""
        query = self._together.get(parts)
        if query is None:
            known = self._together.get(parts[1:])  # one conjunct of the goal is added after the other
            rest = [self.task.goal[part].query for part in parts[1:]] if known is None else [known]
            first = [self.task.goal[part].query for part in parts[:1]]
            query = self._together[parts] = conjunction(first + rest)
        return query.holds(node[0], self.oracle(node[1]))

    def held_conjuncts(self, node: Node) -> list[int]:
        """The indices of all goal conjuncts that hold at a node."""
        test = self.oracle(node[1])
        return [number for number, part in enumerate(self.task.goal) if part.query.holds(node[0], test)]

    def moves(
        self, node: Node, among: frozenset[int] | None = None, without: frozenset[int] = frozenset()
    ) -> Iterator[Move]:
        """Every applicable action with every attempt that geometry allows, actions in the order of the file.

        Actions that change neither knowledge nor geometry are left out, and so is sensing of what is known
        already.

        Args:
            node: the node at which the moves begin.
            among: if given, only actions with these indices are used.
            without: skip the actions with these indices.
        """
        state, trace = node
        test = self.oracle(trace)
        listed = self._listed(state) if among is None else map(self._entries.__getitem__, among)
        found = [entry for entry in listed if state & entry[1] == entry[2]]
        found.sort(key=_place)
        for index, _, _, rest, action, after_of in found:
            if index in without:
                continue
            if rest is not None and not rest.holds(state, test):
                continue
            after = after_of(state, test)
            if after is None or (after == state and (self._is_free(action) or action.sense)):
                continue
            for attempt, trace_after in self._options(action, trace):
                yield action, attempt, (after, trace_after)

    def _listed(self, state: int) -> Iterator[_Indexed]:
        """The actions whose preconditions may hold in the state."""
        for bit in (0, *bits_of(state & self._indexed)):
            yield from self._by_bit.get(bit, ())

    def after(self, node: Node, step: Step) -> Node:
        """The node after a step that is known to be applicable."""
        state, trace = node
        if isinstance(step, Assume):
            return dict(step.branching.outcomes(state))[step.outcome], trace
        after = step.action.after(state, self.oracle(trace))
        assert after is not None, f"{step.action} contradicts itself"
        return after, trace if self._is_free(step.action) else step.trace

    def possible(self, node: Node, step: Step) -> Node | None:
        """The node after a step, or None if the step is not applicable at the node."""
        state, trace = node
        if isinstance(step, Assume):
            if step.branching not in self._next(state):
                return None
            after = dict(step.branching.outcomes(state)).get(step.outcome)
            return None if after is None else (after, trace)
        if not step.action.applicable(state, self.oracle(trace)):
            return None
        after = step.action.after(state, self.oracle(trace))
        if after is None or self._is_free(step.action):
            return None if after is None else (after, trace)
        allowed = (option for option in self._options(step.action, trace) if option[0] == step.attempt)
        return next(((after, made) for _, made in allowed), None)

    def leaves(self, node: Node) -> "list[tuple[tuple[Assume, ...], Node]]":
        """The nodes reached by all open branchings, each with the sequence of outcomes assumed to reach it.

        A node that fulfils the goal is not branched further. Where branching may be postponed, the result also
        contains nodes with some or all outcomes still open.
        """
        if not open_entries(node[0], self.task.pending):
            return [((), node)]
        found: list[tuple[tuple[Assume, ...], Node]] = []
        seen: set[int] = set()  # several orders lead to the same knowledge
        waiting: list[tuple[tuple[Assume, ...], Node]] = [((), node)]
        while waiting:
            decided, here = waiting.pop()
            if here[0] in seen:
                continue
            seen.add(here[0])
            branchings = [] if self.is_goal(here) else self._next(here[0])
            if self.may_wait or not branchings:
                found.append((decided, here))
            for branching in reversed(branchings):
                outcomes = self.outcomes(here, branching)[:: 1 if self.assume_last else -1]
                waiting += [((*decided, Assume(branching, name)), child) for name, child in outcomes]
        return found

    def _next(self, state: int) -> "list[Branching]":
        """The branchings that may come next: all open ones where branching may wait, else the first."""
        if self.may_wait:
            return self.task.open_branchings(state)
        branching = self.task.open_branching(state)
        return [] if branching is None else [branching]

    def geometry_key(self, node: Node) -> Hashable:
        """The part of a node's key that identifies its geometric state; None without geometry."""
        return None if self.geometry is None else self.geometry.key(node[1])

    def delivered(self, node: Node, step: Act, after: Node) -> tuple[str, ...]:
        """The facts that a step senses and that were neither known nor already sensed before it."""
        new = after[0] & ~node[0] & self.task.whether
        facts = {self.task.entries[bit] for bit in bits_of(new)}
        return tuple(fact for fact in step.action.sense if fact in facts)

    def outcomes(self, node: Node, branching: Branching) -> list[tuple[str, Node]]:
        """The outcomes of a branching, each with the node after it, in the order that plans use."""
        return [(outcome, (state, node[1])) for outcome, state in branching.outcomes(node[0])]

    def _is_free(self, action: GroundAction) -> bool:
        """Whether the action calls no geometric procedure."""
        return self.geometry is None or action.call is None

    def _options(self, action: GroundAction, trace: Trace) -> "list[tuple[int, Trace]]":
        if self.geometry is None or action.call is None:
            return [(0, trace)]
        return list(self.geometry.options(action.call, trace))


def _rarest(value: int, filed: Mapping[int, Sequence[_Indexed]]) -> int:
    """The bit of a precondition under which fewest actions are filed so far; 0 if the precondition has no bit."""
    return min(bits_of(value), key=lambda bit: len(filed.get(bit, ())), default=0)


def _place(entry: _Indexed) -> int:
    return entry[0]


@dataclass(frozen=True)
class _Oracle:
    geometry: Geometry
    trace: Trace

    def __call__(self, call: GroundCall) -> bool:
        return self.geometry.test(call, self.trace)
