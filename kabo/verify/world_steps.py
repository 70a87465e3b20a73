"""One node of a plan in one world: what its action really does, and which branch the world takes.

A step has three phases, so that one that comes upon an open value can go on where it was: the action changes the
world; what the action says of the world after it is compared with it; the plan branches.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from kabo.language.formulas import Change, Comparison, Conditional, Effect, FactForall, ForEach, Temporal
from kabo.plan import Node, Plan
from kabo.verify.ground import Binding, NotVerifiableError, Symbol, Value, claim_text, range_of
from kabo.verify.interpreter import Interpreter, is_symbol, outcome_text
from kabo.verify.knowledge import Facts, Frozen, Knowledge, truth
from kabo.verify.relevance import Relevance, forget
from kabo.verify.steps import Step, because, step
from kabo.verify.true_world import OpenError, Pending, Verdict, World, verdict
from kabo.verify.updates import Assignment, Pair, Rule, Updates, When, fired, rules_of

ROUNDS = 100  # of update rules in one world

Mind = tuple[str, Frozen] | None  # a node and a knowledge state there


class WrongError(Exception):
    """Something does not hold in this world."""


class RuledOutError(Exception):
    """An action says something of the world that is not so in this one: it cannot be the case."""


@dataclass(frozen=True)
class Moved:
    """Where a step leads: the next node (None: the goal is reached), what is known there, and whether it acted."""

    successor: str | None
    mind: Mind = None
    counts: int = 0


@dataclass(frozen=True)
class _Act:
    """An action in worlds: verdicts on its preconditions, and its effects."""

    preconditions: tuple[Verdict, ...]
    effects: tuple[Rule, ...]


class Player:
    """Plays the nodes of one plan in worlds.

    `root` is what is known at the start, None if no effect of the plan depends on what is known.
    """

    def __init__(self, plan: Plan, interpreter: Interpreter, relevance: Relevance, start: Knowledge) -> None:
        self.plan, self.interpreter, self.relevance = plan, interpreter, relevance
        self.problem = interpreter.problem
        self._acts: dict[tuple[str, tuple[tuple[str, object], ...]], _Act] = {}
        self._always: list[Verdict] = []
        self._goal = tuple(verdict(part, self.problem, {}, self._temporal) for part in self.problem.goal)
        self._states: dict[tuple[str, Frozen], Knowledge] = {}
        self._steps: dict[tuple[str, Frozen], Step] = {}
        names = {node.action for node in plan.nodes.values() if node.action is not None}
        actions = [self.problem.domain.actions[name] for name in sorted(names)]
        depends = interpreter.rules.rules or any(_depends_on_knowledge(a.effects) for a in actions)
        self.root: Mind = self._mind(plan.root, start) if depends else None

    def _temporal(self, formula: Temporal, binding: Binding) -> Verdict:
        inner = verdict(formula.body, self.problem, binding)
        if formula.kind == "initially":
            return lambda world: None if world.first is None else inner(world.first)
        number = len(self._always)
        self._always.append(inner)
        return lambda world: False if number in world.failed else None

    # ------------------------------------------------------------------------------------------------ knowledge
    def _mind(self, name: str, state: Knowledge) -> tuple[str, Frozen]:
        rest = forget(state, self.relevance.kept(name))
        key = name, rest.frozen()
        self._states.setdefault(key, rest)
        return key

    def _known_step(self, mind: Mind) -> Step | None:
        if mind is None:
            return None
        if mind not in self._steps:
            self._steps[mind] = step(self.interpreter, self.plan.nodes[mind[0]], self._states[mind])
        return self._steps[mind]

    # ---------------------------------------------------------------------------------------------------- steps
    def step(self, name: str, phase: int, world: World, mind: Mind) -> Moved:
        """Plays a node from one of its phases on; the world is changed in place.

        Raises:
            OpenError: a value is open that matters; its `phase` says where to go on.
            WrongError: the plan is wrong for this world.
            RuledOutError: the world turns out to be impossible.
        """
        node = self.plan.nodes[name]
        if node.kind == "goal":
            self._leaf(world)
            return Moved(None)
        known = self._known_step(mind)
        try:
            if phase == 0 and node.action is not None:
                self._act(node, world, mind, known)
            phase = max(phase, 1)
            if world.pending is not None:
                self._agree(world, known)
                world.pending = None
            phase = 2
            return self._go(name, node, world, known)
        except OpenError as error:
            error.phase = phase
            raise
        except NotVerifiableError as error:
            raise WrongError(str(error)) from None

    def _leaf(self, world: World) -> None:
        for formula, judge in zip(self.problem.goal, self._goal, strict=True):
            if judge(world) is False:
                raise WrongError("the goal claims to know what is not so" + because(formula))

    def watch(self, world: World) -> None:
        """Notes the `always` goals that are false now."""
        if self._always:
            wrong = {number for number, judge in enumerate(self._always) if judge(world) is False}
            world.failed |= wrong

    # -------------------------------------------------------------------------------------------------- actions
    def _act(self, node: Node, world: World, mind: Mind, known: Step | None) -> None:
        act = self._ground(node)
        schema = self.problem.domain.actions[str(node.action)]
        for number, (formula, judge) in enumerate(zip(schema.preconditions, act.preconditions, strict=True), 1):
            if judge(world) is False:
                raise WrongError(
                    f'precondition {number} of "{node.action}" claims to know what is not so' + because(formula)
                )
        if mind is not None and known is not None:
            if known.after is None:
                raise WrongError("; ".join(known.messages) or f'"{node.action}" is not applicable')
            world.mind = self._states[mind]
        updates = fired(act.effects, world)
        happening = [
            outcome for effect in updates.worlds if _happens(effect, world) for outcome in effect.outcomes
        ]
        self._look_up([*happening, *updates.adds])
        changed = self._change(world, updates, happening, None if known is None else known.after)
        if updates.entries or updates.complete or (changed and self.interpreter.rules.rules):
            world.pending = Pending(tuple(updates.entries), tuple(updates.complete), frozenset(changed))

    def _ground(self, node: Node) -> _Act:
        key = str(node.action), tuple(sorted(node.arguments.items(), key=lambda pair: pair[0]))
        if key not in self._acts:
            schema, binding = self.problem.domain.actions[str(node.action)], dict(node.arguments)
            self._acts[key] = _Act(
                tuple(verdict(part, self.problem, binding) for part in schema.preconditions),
                tuple(rules_of(schema.effects, self.problem, binding)),
            )
        return self._acts[key]

    def _look_up(self, assignments: Iterable[Assignment]) -> None:
        """What takes the value of an open term must know it."""
        for each in assignments:
            if each.value is None and each.source is not None and range_of(self.problem, each.source) is not None:
                raise OpenError(each.source)

    def _change(
        self, world: World, updates: Updates, happening: Iterable[Assignment], after: Knowledge | None
    ) -> set[Symbol]:
        """Deletions may change what they delete; then `when` effects, then additions."""
        changed: set[Symbol] = set()
        ceasing = [claim for claim in updates.deletions if truth(claim, world) is not False]
        for symbol, _, _ in ceasing:
            self._leave_open(world, symbol, after)
            changed.add(symbol)
        values: dict[Symbol, set[Value | None]] = {}
        for outcome in happening:
            values.setdefault(outcome.symbol, set()).add(outcome.value)
        for symbol, ones in values.items():
            if len(ones) > 1:
                world.leave_open(symbol, set(range_of(self.problem, symbol) or ()) - ones)
            else:
                self._put(world, symbol, next(iter(ones)))
            changed.add(symbol)
        for add in updates.adds:
            changed.add(add.symbol)
            if add.positive:
                self._put(world, add.symbol, add.value)
            elif add.value is not None and truth((add.symbol, add.value, False), world) is not True:
                self._leave_open(world, add.symbol, after, add.value)
        return changed

    def _put(self, world: World, symbol: Symbol, value: Value | None) -> None:
        if value is None:
            world.leave_open(symbol)
        else:
            world.put(symbol, value)

    def _leave_open(self, world: World, symbol: Symbol, after: Knowledge | None, *without: Value) -> None:
        """Any value from now on, but what is still known to be excluded."""
        if after is not None and symbol in after.known:
            world.put(symbol, after.known[symbol])
        else:
            kept = frozenset() if after is None else after.excluded.get(symbol, frozenset())
            world.leave_open(symbol, kept.union(without))

    # ------------------------------------------------------------------------------ what is said of the world
    def _agree(self, world: World, known: Step | None) -> None:
        assert world.pending is not None
        pending = world.pending
        try:
            if self.interpreter.rules.rules:
                self._ramify(world, set(pending.changed))
            for database, entry in pending.entries:
                _check_entry(database, [truth(claim, world) for claim in entry], [claim[0] for claim in entry])
            after: Facts | None = None if known is None else known.after
            for claims in pending.conjunctions:
                if after is None or not all(truth(claim, after) for claim in claims):
                    _check_false([truth(claim, world) for claim in claims], [claim[0] for claim in claims])
        except OpenError:
            world.pending = replace(pending, chosen=True)
            raise

    def _ramify(self, world: World, changed: set[Symbol]) -> None:
        """Update rules are truths about the world: what they conclude from all of it is made so."""
        for symbol in sorted(changed, key=repr):
            if symbol not in world.known and self.interpreter.rules.set_off_by([symbol]):
                raise OpenError(symbol)
        for _ in range(ROUNDS):
            updates = fired(self.interpreter.rules.set_off_by(changed), world.as_known())
            changed = set()
            for add in updates.adds:
                if add.value is None or truth((add.symbol, add.value, add.positive), world):
                    continue
                if not add.positive:
                    raise RuledOutError
                world.put(add.symbol, add.value)
                world.ramified = True
                changed.add(add.symbol)
            for database, entry in updates.entries:
                _check_entry(database, [truth(claim, world) for claim in entry], [claim[0] for claim in entry])
            if not changed:
                return
        raise RuledOutError

    # --------------------------------------------------------------------------------------------------- onward
    def _go(self, name: str, node: Node, world: World, known: Step | None) -> Moved:
        counts = int(node.action is not None)
        if node.action is not None:
            self.watch(world)
        if node.on is None:
            return Moved(node.next, self._onward(None, world, known), counts)
        value = self._sensed(node.on, world)
        outcome = outcome_text(value)
        if outcome not in node.branches:
            raise WrongError(f"no branch for {node.on} = {outcome}, which is the case")
        return Moved(node.branches[outcome], self._onward(value, world, known), counts)

    def _sensed(self, text: str, world: World) -> Value:
        thing = self.interpreter.read(text)
        assert thing is not None  # check_call has read it
        if is_symbol(thing):
            return world.value(thing)  # type: ignore[arg-type]
        return all(world.holds(claim) for claim in thing)  # type: ignore[arg-type]

    def _onward(self, value: Value | None, world: World, known: Step | None) -> Mind:
        """What is known at the next node; it must be true."""
        if known is None:
            return None
        for way in known.ways:
            if way.value == value:
                self._check_knowledge(way.state, world)
                return self._mind(way.successor, way.state)
        if world.ramified:
            raise RuledOutError
        raise WrongError("; ".join(known.messages) or f"{value} was held to be impossible, and is the case")

    def _check_knowledge(self, state: Knowledge, world: World) -> None:
        for symbol, value in state.known.items():
            true = world.known.get(symbol)
            if true is not None and true != value:
                if world.ramified:
                    raise RuledOutError
                raise WrongError(f"{claim_text((symbol, value, True))} is known behind it, and is not so")


def _happens(effect: When, world: World) -> bool:
    """Whether all conditions of a `when` effect are true."""
    first_open: Symbol | None = None
    for condition in effect.conditions:
        if isinstance(condition, Pair):
            first_open = condition.left if condition.left not in world.known else condition.right
            continue
        true = condition if isinstance(condition, bool) else truth(condition, world)
        if true is False:
            return False
        if true is None and not isinstance(condition, bool):
            first_open = condition[0]
    if first_open is not None:
        raise OpenError(first_open)
    return True


def _check_entry(database: str, truths: list[bool | None], symbols: list[Symbol]) -> None:
    holding = truths.count(True)
    if (database == "Kx" and holding > 1) or (holding == 0 and None not in truths):
        raise RuledOutError
    if None in truths and (database == "Kx" or holding == 0):
        raise OpenError(symbols[truths.index(None)])


def _check_false(truths: list[bool | None], symbols: list[Symbol]) -> None:
    if False in truths:
        return
    if None in truths:
        raise OpenError(symbols[truths.index(None)])
    raise RuledOutError


def _depends_on_knowledge(effects: Iterable[Effect]) -> bool:
    """Whether what an action does to the world depends on what is known."""
    return any(map(_depends, _flat(effects)))


def _flat(effects: Iterable[Effect]) -> Iterator[Effect]:
    for effect in effects:
        if isinstance(effect, ForEach):
            yield from _flat(effect.effects)
        else:
            yield effect


def _depends(effect: Effect) -> bool:
    if isinstance(effect, Conditional):
        return True
    if not isinstance(effect, Change) or effect.database not in ("Kf", "LCW"):
        return False
    if effect.database == "LCW":
        return effect.operation == "add"
    facts = [fact.body if isinstance(fact, FactForall) else fact for fact in effect.facts]
    return any(isinstance(f, Comparison) and (effect.operation == "del" or f.operator == "!=") for f in facts)
