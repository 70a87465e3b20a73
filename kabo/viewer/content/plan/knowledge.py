"""What is known along a plan: the knowledge before each node, and what the node adds and removes, by database.

A node that is reached on several ways has a state of knowledge for each. What all have in common is certain there; facts
of only some ways are kept apart, and the page says so.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from kabo.knowledge import GroundAction, GroundedTask, ground
from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import AtomBits, Claim, ConjunctionBits, Group, NumberBits, TermBits
from kabo.language import Problem, spell_bound
from kabo.language.formulas import Change, Conditional, Effect
from kabo.plan import Node, Plan, ValueOf, topological_order

MOST_STATES = 2048  # states of knowledge that are followed at one node
Fact = tuple[str, str]  # database and text


@dataclass
class _Facts:
    """All facts that occur, numbered in the order in which they are met."""

    numbers: dict[Fact, int] = field(default_factory=dict)

    def of(self, facts: Iterable[Fact]) -> list[int]:
        return [self.numbers.setdefault(fact, len(self.numbers)) for fact in facts]


def knowledge_view(plan: Plan, problem: Problem) -> dict[str, Any] | None:
    """The knowledge along a plan; None if it cannot be followed: the plan is not of this problem.

    `facts` are [database, text]; `nodes` maps each node to `before` (known there on every way), `sometimes` (on some
    ways only), `added` and `removed` by its action, `outcomes` with what each adds and removes, all as numbers of facts;
    and to `ways`, the number of states of knowledge that it is reached in, with `more` if these are not all.

    Raises:
        InputError: the problem uses something that kabo does not support.
    """
    order = topological_order(plan)
    if order is None:
        return None
    task, facts = ground(problem), _Facts()
    reading = _Reading(task)
    actions = {_key(action.name, action.arguments): action for action in task.actions}
    arriving: dict[str, dict[int, None]] = {name: {} for name in order}
    arriving[plan.root][task.initial] = None
    crowded: set[str] = set()
    nodes: dict[str, Any] = {}
    for name in order:
        node, states = plan.nodes[name], list(arriving[name])
        step = _step(node, states, task, actions)
        if step is None:
            return None
        nodes[name] = _node_view(reading, facts, states, step, _closed_worlds(node, problem))
        nodes[name]["more"] = name in crowded
        for target, after in step.onward(node):
            known = arriving[target]
            known.update(dict.fromkeys(after))
            if len(known) > MOST_STATES or name in crowded:
                crowded.add(target)
                arriving[target] = dict.fromkeys(list(known)[:MOST_STATES])
    return {"facts": [list(fact) for fact in facts.numbers], "nodes": nodes}


# ------------------------------------------------------------------------------------------------------------ steps
@dataclass(frozen=True)
class _Step:
    """The states after a node's action, one for each state before; and those after each outcome (None: impossible)."""

    after: list[int]
    outcomes: Mapping[str, list[int | None]]

    def onward(self, node: Node) -> Iterator[tuple[str, list[int]]]:
        """Each successor with the states in which it is reached."""
        for outcome, target in node.branches.items():
            yield target, [state for state in self.outcomes[outcome] if state is not None]
        if not node.branches and node.next is not None:
            yield node.next, self.after


def _step(
    node: Node, states: Sequence[int], task: GroundedTask, actions: Mapping[tuple[str, ...], GroundAction]
) -> _Step | None:
    after = list(states)
    if node.action is not None:
        action = actions.get(_key(node.action, {name: _argument(value) for name, value in node.arguments.items()}))
        if action is None:
            return None
        made = [action.after(state) for state in states]
        if any(state is None for state in made):
            return None
        after = [state for state in made if state is not None]
    outcomes: dict[str, list[int | None]] = {}
    if node.branches:
        branching = next((each for each in task.branchings.values() if each.fact == node.on), None)
        if branching is None:
            return None
        choices = {choice.outcome: choice for choice in branching.choices}
        if not set(node.branches) <= set(choices):
            return None
        outcomes = {each: [branching.after(state, choices[each]) for state in after] for each in node.branches}
    return _Step(after, outcomes)


def _key(name: str, arguments: Mapping[str, object]) -> tuple[str, ...]:
    """An action with its arguments in the order of their names, since plan files sort them so."""
    return name, *(str(arguments[each]) for each in sorted(arguments))


def _argument(value: str | float | ValueOf) -> str:
    if isinstance(value, ValueOf):
        return value.term
    return value if isinstance(value, str) else f"{value:g}"


def _closed_worlds(node: Node, problem: Problem) -> tuple[list[Fact], list[Fact]]:
    """The local closed worlds that a node's action adds and removes, as its effects write them."""
    action = next((each for each in _actions(problem) if each.name == node.action), None)
    found: tuple[list[Fact], list[Fact]] = [], []
    if action is not None:
        binding = {name: _argument(value) for name, value in node.arguments.items()}
        for change in _changes(action.effects):
            if change.database == "LCW":
                texts = [("LCW", spell_bound(fact, binding)) for fact in change.facts]
                found[change.operation == "del"].extend(texts)
    return found


def _actions(problem: Problem) -> Iterable[Any]:
    actions = problem.domain.actions
    return actions.values() if isinstance(actions, Mapping) else actions


def _changes(effects: Iterable[Effect]) -> Iterator[Change]:
    for effect in effects:
        if isinstance(effect, Change):
            yield effect
        elif isinstance(effect, Conditional):
            yield from _changes(effect.updates)


# ------------------------------------------------------------------------------------------------------------ views
def _node_view(
    reading: "_Reading",
    facts: _Facts,
    states: Sequence[int],
    step: _Step,
    closed_worlds: tuple[list[Fact], list[Fact]],
) -> dict[str, Any]:
    before = [reading.of(state) for state in states]
    after = [reading.of(state) for state in step.after]
    common, sometimes = _split(before)
    added, maybe_added = _split([_less(new, old) for new, old in zip(after, before, strict=True)])
    removed, maybe_removed = _split([_less(old, new) for new, old in zip(after, before, strict=True)])
    outcomes = {}
    for outcome, reached in step.outcomes.items():
        pairs = [(reading.of(new), old) for new, old in zip(reached, after, strict=True) if new is not None]
        gain, some_gain = _split([_less(new, old) for new, old in pairs])
        loss, _ = _split([_less(old, new) for new, old in pairs])
        outcomes[outcome] = {
            "added": facts.of(gain),
            "sometimes": facts.of(some_gain),
            "removed": facts.of(loss),
            "possible": len(pairs),
        }
    return {
        "ways": len(states),
        "before": facts.of(common),
        "sometimes": facts.of(sometimes),
        "added": facts.of([*added, *closed_worlds[0]]),
        "removed": facts.of([*removed, *closed_worlds[1]]),
        "maybe_added": facts.of(maybe_added),
        "maybe_removed": facts.of(maybe_removed),
        "outcomes": outcomes,
    }


def _split(sets: Sequence[Mapping[Fact, None]]) -> tuple[list[Fact], list[Fact]]:
    """The facts of all sets, and those of some sets only, in the order in which they occur."""
    if not sets:
        return [], []
    every = dict.fromkeys(fact for each in sets for fact in each)
    common = {fact: None for fact in sets[0] if all(fact in each for each in sets[1:])}
    return list(common), [fact for fact in every if fact not in common]


def _less(first: Mapping[Fact, None], second: Mapping[Fact, None]) -> dict[Fact, None]:
    return {fact: None for fact in first if fact not in second}


class _Reading:
    """Reads states of knowledge as facts."""

    def __init__(self, task: GroundedTask) -> None:
        self._groups = task.groups
        self._entries = [each for each in task.closure.propagators if isinstance(each, Entry)]
        self._known: dict[int, dict[Fact, None]] = {}

    def of(self, state: int) -> dict[Fact, None]:
        """The facts of a state, in the order of its groups; the entries of Kx and Kor follow."""
        if state not in self._known:
            found = [fact for group in self._groups for fact in _group_facts(group, state)]
            found += [fact for entry in self._entries for fact in _entry_facts(entry, state)]
            self._known[state] = dict.fromkeys(found)
        return self._known[state]


def _group_facts(group: Group, state: int) -> Iterator[Fact]:
    match group:
        case AtomBits():
            if state & group.known:
                yield "Kf", group.text if state & group.true else f"not {group.text}"
            elif state & group.whether:
                yield "Kw", group.text
        case TermBits():
            yield from _term_facts(group, state)
        case NumberBits():
            value = group.decode(state)
            if value is not None:
                yield "Kf", f"{group.text} = {value:g}"
            elif state & group.whether:
                yield "Kv", group.text
        case ConjunctionBits():
            if state & group.whether:
                yield "Kw", group.text


def _term_facts(group: TermBits, state: int) -> Iterator[Fact]:
    value = next((value for value, bit in group.equal.items() if state & bit), None)
    if value is not None:
        yield "Kf", f"{group.text} = {value}"
        return
    yield from (("Kf", f"{group.text} != {value}") for value, bit in group.unequal.items() if state & bit)
    if state & group.whether and not state & group.settled:
        yield "Kv", group.text


def _entry_facts(entry: Entry, state: int) -> Iterator[Fact]:
    """The entry with the members that are still open; nothing if it is not in the state, or one is known to hold."""
    if state & entry.holds or (entry.active and not state & entry.active):
        return
    left = [_spelled(member) for member in entry.members if not state & member.fails]
    if len(left) > 1:
        yield "Kx" if entry.exactly else "Kor", f"{{{', '.join(left)}}}"


def _spelled(claim: Claim) -> str:
    group = claim.group
    if isinstance(group, AtomBits):
        return group.text if claim.holds == group.true else f"not {group.text}"
    assert isinstance(group, TermBits)
    value = next(v for v in group.equal if claim.holds in (group.equal[v], group.unequal.get(v)))
    return f"{group.text} {'=' if claim.holds == group.equal[value] else '!='} {value}"
