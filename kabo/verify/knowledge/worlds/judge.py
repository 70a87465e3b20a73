"""Judges a plan in all possible worlds: every action is applicable, every outcome has a branch, every leaf is a goal.

A node is examined once for each *belief* that can arrive at it: the worlds that agree with what was observed on the way.
A perfect reasoner knows what holds in all of them. Nothing is inferred here and nothing is sampled: every condition is
looked up in every world. Worlds stay few, because a world leaves values open until something depends on them.
"""

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

from kabo.language.formulas import And, Forall, Formula, Temporal
from kabo.language.problem import Problem
from kabo.phases import phase
from kabo.plan import Node, Plan, ValueOf
from kabo.verify.knowledge.external_procedures import external_of
from kabo.verify.knowledge.facts import truth
from kabo.verify.knowledge.ground import (
    Binding,
    GroundClaim,
    NotVerifiableError,
    Observable,
    Symbol,
    Value,
    because,
    instances,
    is_symbol,
    outcome_text,
    range_of,
    read_observable,
    read_symbol,
)
from kabo.verify.knowledge.mentions import mentions
from kabo.verify.knowledge.past import is_past
from kabo.verify.knowledge.worlds.acts import Act, NotApplicableError, act_of, observed, perform
from kabo.verify.knowledge.worlds.belief import Belief, without
from kabo.verify.knowledge.worlds.initial import NoWorldError, Start, start_of
from kabo.verify.knowledge.worlds.needs import Needs, never_hurt_by_knowledge
from kabo.verify.knowledge.worlds.queries import Query, asks_procedures, query, required
from kabo.verify.knowledge.worlds.world import MAX_VALUES, CannotJudgeError, Key, World, every, in_words
from kabo.verify.report import Finding, WorldReport

_LOG = logging.getLogger("kabo.verify")
MAX_SHOWN_UNKNOWNS = 6  # unknowns that the text of a finding names

NO_WORLD = "the initial knowledge: no world agrees with all of it, it contradicts itself"


@dataclass(frozen=True)
class _Goal:
    """A conjunct of the goal."""

    formula: Formula
    asked: Query
    only_knowledge: bool
    mentioned: tuple[Symbol | str, ...]
    temporal: bool  # whether it is about other states than the last

    def stays(self, belief: Belief, read_later: Callable[[Symbol | str], bool]) -> bool:
        """Whether it holds, and no observation will make it false as long as nothing changes what it mentions.

        Some formulas are never made false by more knowledge. Others stay true if nothing more can be learned about what
        they mention: it is known, or it is open in every world, linked to nothing, and no later node mentions it.
        """
        if self.temporal or not self.asked((belief, belief)):
            return False
        return self.only_knowledge or all(
            thing in belief.known or (not read_later(thing) and belief.is_free(thing)) for thing in self.mentioned
        )


@dataclass
class _Arrival:
    """A belief at a node, and the least and the greatest number of actions on the way there."""

    belief: Belief
    shortest: int
    longest: int
    worlds: dict[Key, World] = field(default_factory=dict)  # those of the belief, by their keys

    def meet(self, other: "_Arrival") -> None:
        """Merges another arrival with the same belief into this one."""
        for key, world in other.worlds.items():
            self.worlds[key].share += world.share
        self.shortest, self.longest = min(self.shortest, other.shortest), max(self.longest, other.longest)


@dataclass
class Judgement:
    """The result of following a plan through all worlds: the report, and the number of examined beliefs."""

    report: WorldReport
    states: int


def judge_in_worlds(problem: Problem, plan: Plan, order: Sequence[str], *, limit: int = MAX_VALUES) -> Judgement:
    """Judges a plan in all possible worlds; the calls of its nodes must have passed `check_calls`.

    Args:
        problem: the problem.
        plan: the plan.
        order: the plan's reached nodes, each before its successors.
        limit: the largest permitted number of values of atoms and terms, summed over all worlds that are created.

    Raises:
        CannotJudgeError: worlds cannot judge this plan; the text says why not.
    """
    _check_judged(problem, plan, order)
    try:
        start = start_of(problem)
        return _WorldsRun(problem, plan, order, start, limit).judgement()
    except NoWorldError:
        return Judgement(WorldReport((Finding(None, NO_WORLD),)), 1)
    except NotVerifiableError as error:
        raise CannotJudgeError(str(error)) from None


def _check_judged(problem: Problem, plan: Plan, order: Sequence[str]) -> None:
    """Refuses what worlds cannot judge, as far as the problem and the plan show it.

    Raises:
        CannotJudgeError: the text says what.
    """
    if problem.domain.update_rules:
        raise CannotJudgeError("the domain has update rules, which infer from what is known")
    names = {plan.nodes[name].action for name in order} - {None}
    for name in sorted(map(str, names)):
        action = problem.domain.actions[name]
        if external_of(action.geometry, problem) is not None:
            raise CannotJudgeError(f'a function answers for the procedure of "{name}"')
        if asks_procedures((action.preconditions, action.effects)):
            raise CannotJudgeError(f'"{name}" asks an external procedure')
    if asks_procedures((problem.goal, problem.initial)):
        raise CannotJudgeError("the goal or the initial knowledge asks an external procedure")


class _WorldsRun:
    """One plan, followed through all worlds."""

    def __init__(self, problem: Problem, plan: Plan, order: Sequence[str], start: Start, limit: int) -> None:
        self.problem, self.plan, self.order, self.start = problem, plan, order, start
        start.unknowns.values_left = limit
        self._acts: dict[object, Act] = {}
        self._always: list[Query] = []
        self._first: set[Symbol] = set()
        self._temporals = 0  # temporal formulas in the conjunct that is being read
        throughout: list[Symbol | str] = []
        self.goals: list[_Goal] = []
        for formula, binding in self._conjuncts():
            asked = query(formula, problem, binding, self._temporal)
            mentioned = tuple(dict.fromkeys(mentions(formula, problem, binding)))
            only, temporal = never_hurt_by_knowledge(formula), self._temporals > 0
            self.goals.append(_Goal(formula, asked, only, mentioned, temporal))
            if temporal:
                self._temporals, throughout = 0, [*throughout, *mentioned]
        self.needs = Needs(plan, order, problem, [goal.mentioned for goal in self.goals], throughout)
        self.findings: dict[tuple[str, str], Finding] = {}
        self.states = self.ruled_out = 0
        self.actions = 0.0
        self.agreeing: float | None = (
            None  # share of the worlds that agree with what was done before the plan begins
        )
        self.ends: list[_Arrival] = []

    def _conjuncts(self) -> Iterator[tuple[Formula, Binding]]:
        """The goal without its outer conjunctions and universal quantifiers."""
        waiting: list[tuple[Formula, Binding]] = [(formula, {}) for formula in reversed(self.problem.goal)]
        while waiting:
            formula, binding = waiting.pop()
            if isinstance(formula, And):
                waiting.extend((part, binding) for part in reversed(formula.parts))
            elif isinstance(formula, Forall):
                more = list(instances(self.problem, formula.variables, binding))
                waiting.extend((formula.body, each) for each in reversed(more))
            else:
                yield formula, binding

    def _temporal(self, formula: Temporal, binding: Binding) -> int:
        self._temporals += 1
        if formula.kind == "always":
            self._always.append(query(formula.body, self.problem, binding))
            return len(self._always) - 1
        for thing in mentions(formula.body, self.problem, binding):
            self._first.update(self._all_of(thing) if isinstance(thing, str) else [thing])
        return -1

    def _all_of(self, name: str) -> Iterator[Symbol]:
        """Every instance of a symbol's name."""
        domain = self.problem.domain
        kinds = domain.predicates[name] if name in domain.predicates else domain.functions[name].arguments
        for arguments in product(*map(self.problem.of_type, kinds)):
            yield name, arguments

    # ------------------------------------------------------------------------------------------------- the run
    def judgement(self) -> Judgement:
        """Follows every belief through the plan."""
        arriving: dict[str, dict[Key, _Arrival]] = {name: {} for name in self.order}
        self._arrive(arriving, self.plan.root, _Arrival(self._begin(), 0, 0))
        with phase("following worlds", len(self.order), "nodes", log=_LOG) as step:
            for name in self.order:
                if self.agreeing is None and not is_past(name):
                    self.agreeing = sum(arrival.belief.share for arrival in arriving[name].values())
                for arrival in arriving.pop(name).values():
                    self.states += 1
                    counts = int(self.plan.nodes[name].action is not None and not is_past(name))
                    self.actions += counts * arrival.belief.share
                    for successor, belief in self._play(name, arrival):
                        more = _Arrival(belief, arrival.shortest + counts, arrival.longest + counts)
                        self._arrive(arriving, successor, more)
                step()
        return Judgement(self._report(), self.states)

    def _begin(self) -> Belief:
        worlds: list[World] = []
        for world in every(self.start.unknowns, self.start.world, frozenset(self._first)):
            world.remember(frozenset(self._first))
            worlds.append(world)
        belief = Belief(
            self.start.unknowns, worlds, self.start.whether, self.start.whole, dict(self.start.explicit)
        )
        self._watch(belief)
        return belief

    def _arrive(self, arriving: Mapping[str, dict[Key, _Arrival]], name: str, arrival: _Arrival) -> None:
        if name not in arriving:
            return  # no node of the plan, as check_structure has reported
        belief = arrival.belief
        for number, goal in enumerate(self.goals):
            if not belief.settled >> number & 1 and self.needs.done(name, number):
                stays = goal.stays(belief, lambda thing: self.needs.read_later(name, thing))
                belief.settled |= int(stays) << number
        keeps, symbols = self.needs.kept(name, belief.settled)
        groups = self.start.unknowns.groups
        kept = frozenset(number for number, group in enumerate(groups) if any(map(keeps, group.symbols)))
        arrival.belief, arrival.worlds, key = without(belief, keeps, kept, symbols)
        for world in arrival.belief.worlds:
            self.start.unknowns.spend(world)
        if key in arriving[name]:
            arriving[name][key].meet(arrival)
        else:
            arriving[name][key] = arrival

    def _watch(self, belief: Belief) -> None:
        """Records the `always` goals that do not hold now."""
        wrong = {n for n, asked in enumerate(self._always) if not required(asked, belief, belief.explicit_belief)}
        belief.broken |= wrong

    def _report(self) -> WorldReport:
        shortest = min((end.shortest for end in self.ends), default=0)
        longest = max((end.longest for end in self.ends), default=0)
        share = sum(end.belief.share for end in self.ends)
        mean = self.actions / share if share else 0.0
        mean = min(max(round(mean, 9), shortest), longest)
        count = self.start.unknowns.count
        if self.plan.done and self.agreeing is not None:
            count = round(count * self.agreeing)
        return WorldReport(tuple(self.findings.values()), count, True, shortest, mean, longest, self.ruled_out)

    # ---------------------------------------------------------------------------------------------------- nodes
    def _play(self, name: str, arrival: _Arrival) -> Iterator[tuple[str, Belief]]:
        """The beliefs at the successors of a node; faults of the node are added to the findings."""
        node, belief = self.plan.nodes[name], arrival.belief
        if node.kind == "goal":
            self._leaf(name, belief)
            self.ends.append(arrival)
            return
        for successor in node.successors:
            later = self.plan.nodes.get(successor)
            if later is not None and later.overlap > 0.0 and later.action is not None:
                for message, _ in self._unmet(successor, self._act(later), belief):
                    self._add_finding(successor, f"begins early, but then {message}", "")
        if node.action is not None:
            after = self._acted(name, node, belief)
            if after is None:
                return
            belief = after
        if node.on is None:
            if node.next is not None:
                yield node.next, belief
            return
        yield from self._branched(name, node, belief)

    def _leaf(self, name: str, belief: Belief) -> None:
        for number, goal in enumerate(self.goals):
            if not belief.settled >> number & 1 and not required(goal.asked, belief, belief.explicit_belief):
                text = "the goal does not hold at this leaf" + because(goal.formula)
                if (name, text) not in self.findings:
                    self._add_finding(name, text, self._shown(goal.asked, belief, goal.mentioned))

    def _act(self, node: Node) -> Act:
        key = node.action, tuple(sorted(node.arguments.items(), key=lambda pair: pair[0]))
        if key not in self._acts:
            terms = [value.term for value in node.arguments.values() if isinstance(value, ValueOf)]
            values = tuple((term, read_symbol(term, self.problem)) for term in terms)
            schema = self.problem.domain.actions[str(node.action)]
            self._acts[key] = act_of(schema, dict(node.arguments), values, self.problem)
        return self._acts[key]

    def _unmet(self, name: str, act: Act, belief: Belief) -> Iterator[tuple[str, str]]:
        """The preconditions of an action that do not hold, each with a world that shows it."""
        for text, symbol in act.values:
            if symbol is None or not belief.will_know(symbol, False):
                yield f"the value of {text} is not known at run time here", ""
        for number, asked in enumerate(act.preconditions, 1):
            if not required(asked, belief, belief.explicit_belief):
                text = f'precondition {number} of "{act.schema.name}" does not hold'
                formula = act.schema.preconditions[number - 1]
                text += because(formula)
                known = (name, text) in self.findings
                mentioned = mentions(formula, self.problem, act.binding)
                yield text, "" if known else self._shown(asked, belief, mentioned)

    def _acted(self, name: str, node: Node, belief: Belief) -> Belief | None:
        act = self._act(node)
        for message, shown in self._unmet(name, act, belief):
            self._add_finding(name, message, shown)
        try:
            after = perform(act, belief)
        except NotApplicableError as error:
            self._add_finding(name, f'"{node.action}" is not applicable: it would mean {error}', "")
            return None
        self.ruled_out += after.ruled_out
        for text in (*([] if node.on is None else [node.on]), *node.delivers):
            if read_observable(text, self.problem) not in after.delivered:
                self._add_finding(name, f'"{node.action}" does not sense {text}', "")
        self._watch(after.belief)
        return after.belief

    def _branched(self, name: str, node: Node, belief: Belief) -> Iterator[tuple[str, Belief]]:
        thing = read_observable(str(node.on), self.problem)
        if thing is None or not _can_branch(belief, thing):
            self._add_finding(name, f"branches on {node.on}, which is not known at run time here", "")
            return
        values = self._outcomes(thing, belief)
        if values is None:
            self._add_finding(name, f"branches on {node.on}, whose values cannot be listed", "")
            return
        names = [outcome_text(value) for value in values]
        for outcome in node.branches:
            if outcome not in names:
                self._add_finding(name, f'"{outcome}" is no value of {node.on}', "")
        parts = observed(belief, thing)
        for value, outcome in zip(values, names, strict=True):
            if value not in parts:
                continue
            self._watch(parts[value])
            if outcome in node.branches:
                yield node.branches[outcome], parts[value]
            elif not is_past(name):
                world = parts[value].worlds[0]
                self._add_finding(name, f"no branch for {node.on} = {outcome}, which is possible", in_words(world))

    def _outcomes(self, thing: Observable, belief: Belief) -> tuple[Value, ...] | None:
        if not is_symbol(thing):
            return (False, True)
        symbol: Symbol = thing  # type: ignore[assignment]
        known = belief.known.get(symbol)
        values = range_of(self.problem, symbol)
        return (known,) if values is None and known is not None else values

    # ------------------------------------------------------------------------------------------------- findings
    def _add_finding(self, name: str, message: str, shown: str) -> None:
        self.findings.setdefault((name, message), Finding(name, message + shown))

    def _shown(self, asked: Query, belief: Belief, mentioned: Iterable[Symbol | str]) -> str:
        """A world in which the query is false even for one who knew all of it, as text; "" if there is none."""
        symbols = frozenset(thing for thing in mentioned if not isinstance(thing, str))
        for world in belief.worlds:
            many = len(symbols - world.known.keys()) > MAX_SHOWN_UNKNOWNS
            for one in [world] if many else every(self.start.unknowns, world, symbols):
                alone = Belief(belief.unknowns, [one], belief.whether, broken=belief.broken)
                if not asked((alone, alone)):
                    return in_words(one)
        return ""


def _can_branch(belief: Belief, thing: Observable) -> bool:
    """Whether the plan may branch here: the truth or value will be known at run time."""
    if is_symbol(thing):
        return belief.will_know(thing, False)  # type: ignore[arg-type]
    if thing in belief.whole:
        return True
    claims: tuple[GroundClaim, ...] = thing  # type: ignore[assignment]
    if any(all(truth(claim, world) is False for world in belief.worlds) for claim in claims):
        return True
    return all(belief.will_know(claim[0], False) for claim in claims)
