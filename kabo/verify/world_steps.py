"""One node of a plan in one world: what its action really does, and which branch the world takes.

A step has three phases, so that one that comes upon an open value can go on where it was: the action changes the
world; what the action says of the world after it is compared with it; the plan branches.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from kabo.language.formulas import Formula, Temporal
from kabo.plan import Plan
from kabo.verify.ground import Binding, Entry, NotVerifiableError, Symbol, Value, claim_text, range_of
from kabo.verify.interpreter import Interpreter, Thing, is_symbol, outcome_text
from kabo.verify.knowledge import Facts, Knowledge, in_order, truth
from kabo.verify.minds import Mind, Minds, depends_on_knowledge
from kabo.verify.relevance import Relevance
from kabo.verify.steps import because
from kabo.verify.true_world import OpenError, Pending, Verdict, World, verdict
from kabo.verify.updates import Assignment, Pair, Rule, Updates, When, fired, rules_of

ROUNDS = 100  # of update rules in one world


class WrongError(Exception):
    """Something does not hold in this world."""


class RuledOutError(Exception):
    """An action says something of the world that is not so in this one: it cannot be the case."""


@dataclass(frozen=True)
class Moved:
    """Where a step leads: the next node (None: the goal is reached), what is known there, and whether it acted."""

    successor: str | None
    mind: Mind | None = None
    counts: int = 0


@dataclass(frozen=True)
class _Act:
    """An action in worlds: verdicts on its preconditions, and its effects."""

    preconditions: tuple[tuple[Formula, Verdict], ...]
    effects: tuple[Rule, ...]


@dataclass(frozen=True)
class _Ground:
    """A node, its action ground and its outcomes as values."""

    action: str | None
    act: _Act | None
    following: str | None
    on: str | None
    thing: Thing | None
    branches: dict[str, str]


class Player:
    """Plays the nodes of one plan in worlds.

    `root` is what is known at the start, None if no effect of the plan depends on what is known.
    """

    def __init__(self, plan: Plan, interpreter: Interpreter, relevance: Relevance, start: Knowledge) -> None:
        self.plan, self.interpreter = plan, interpreter
        self.problem, self.rules = interpreter.problem, interpreter.rules
        self._nodes: dict[str, _Ground] = {}
        self._acts: dict[tuple[str, tuple[tuple[str, object], ...]], _Act] = {}
        self._always: list[Verdict] = []
        self._goal = tuple((part, verdict(part, self.problem, {}, self._temporal)) for part in self.problem.goal)
        self._minds = Minds(plan, interpreter, relevance)
        names = {node.action for node in plan.nodes.values() if node.action is not None}
        depends = any(depends_on_knowledge(self.problem.domain.actions[name].effects) for name in sorted(names))
        self.root: Mind | None = self._minds.at(plan.root, start) if depends else None

    def _temporal(self, formula: Temporal, binding: Binding) -> Verdict:
        inner = verdict(formula.body, self.problem, binding)
        if formula.kind == "initially":
            return lambda world: None if world.first is None else inner(world.first)
        number = len(self._always)
        self._always.append(inner)
        return lambda world: False if number in world.failed else None

    # ---------------------------------------------------------------------------------------------------- steps
    def step(self, name: str, phase: int, world: World, mind: Mind | None) -> Moved:
        """Plays a node from one of its phases on; the world is changed in place.

        Raises:
            OpenError: a value is open that matters; its `phase` says where to go on.
            WrongError: the plan is wrong for this world.
            RuledOutError: the world turns out to be impossible.
        """
        try:
            node = self._nodes.get(name) or self._ground(name)
            if node.act is not None and phase == 0:
                self._act(node, node.act, world, mind)
            phase = max(phase, 1)
            if world.pending is not None:
                self._agree(world, mind)
                world.pending = None
            phase = 2
            return self._go(node, world, mind)
        except OpenError as error:
            error.phase = phase
            raise
        except NotVerifiableError as error:
            raise WrongError(str(error)) from None

    def _ground(self, name: str) -> _Ground:
        node = self.plan.nodes[name]
        act = None
        if node.action is not None:
            key = node.action, tuple(sorted(node.arguments.items(), key=lambda pair: pair[0]))
            if key not in self._acts:
                schema, binding = self.problem.domain.actions[node.action], dict(node.arguments)
                self._acts[key] = _Act(
                    tuple((part, verdict(part, self.problem, binding)) for part in schema.preconditions),
                    tuple(rules_of(schema.effects, self.problem, binding)),
                )
            act = self._acts[key]
        thing = None if node.on is None else self.interpreter.read(node.on)
        self._nodes[name] = _Ground(node.action, act, node.next, node.on, thing, dict(node.branches))
        return self._nodes[name]

    def _leaf(self, world: World) -> None:
        for formula, judge in self._goal:
            if judge(world) is False:
                raise WrongError("the goal claims to know what is not so" + because(formula))

    def watch(self, world: World) -> None:
        """Notes the `always` goals that are false now."""
        if self._always:
            wrong = {number for number, judge in enumerate(self._always) if judge(world) is False}
            world.failed |= wrong

    # -------------------------------------------------------------------------------------------------- actions
    def _act(self, node: _Ground, act: _Act, world: World, mind: Mind | None) -> None:
        for number, (formula, judge) in enumerate(act.preconditions, 1):
            if judge(world) is False:
                text = f'precondition {number} of "{node.action}" claims to know what is not so'
                raise WrongError(text + because(formula))
        after = None
        if mind is not None:
            after = mind.step.after
            if after is None:
                raise WrongError("; ".join(mind.step.messages) or f'"{node.action}" is not applicable')
            world.mind = mind.state
        updates = fired(act.effects, world)
        happening = [
            outcome for effect in updates.worlds if _happens(effect, world) for outcome in effect.outcomes
        ]
        self._look_up([*happening, *updates.adds])
        changed = self._change(world, updates, happening, after)
        if updates.entries or updates.complete or (changed and self.rules.rules):
            world.pending = Pending(tuple(updates.entries), tuple(updates.complete), frozenset(changed))

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
    def _agree(self, world: World, mind: Mind | None) -> None:
        assert world.pending is not None
        pending = world.pending
        try:
            self._obey_rules(world, set(pending.changed))
            for database, entry in pending.entries:
                _check_entry(database, entry, world)
            after: Facts | None = None if mind is None else mind.step.after
            for claims in pending.conjunctions:
                if after is None or not all(truth(claim, after) for claim in claims):
                    _check_false([truth(claim, world) for claim in claims], [claim[0] for claim in claims])
        except OpenError:
            world.pending = replace(pending, chosen=True)
            raise

    def _obey_rules(self, world: World, changed: set[Symbol]) -> None:
        """Update rules are truths about the world: what they conclude from all of it is made so.

        Inference takes the conclusion to have been true before, too. So what goes wrong in such a world later does
        not speak against the plan: it is marked (`ramified`).
        """
        for symbol in sorted((symbol for symbol in changed if symbol not in world.known), key=repr):
            if self.rules.set_off_by([symbol]):
                raise OpenError(symbol)
        for _ in range(ROUNDS):
            rules = self.rules.set_off_by(changed)
            if not rules:
                return
            updates, changed = fired(rules, world.as_known()), set()
            for add in updates.adds:
                if add.value is None or truth((add.symbol, add.value, add.positive), world):
                    continue
                if not add.positive or add.symbol in changed:
                    raise RuledOutError
                world.put(add.symbol, add.value)
                world.ramified = True
                changed.add(add.symbol)
            for database, entry in updates.entries:
                _check_entry(database, entry, world)
        raise RuledOutError

    # --------------------------------------------------------------------------------------------------- onward
    def _go(self, node: _Ground, world: World, mind: Mind | None) -> Moved:
        if node.thing is None:
            if node.following is None:
                self._leaf(world)
                return Moved(None)
            if node.act is not None:
                self.watch(world)
            return Moved(node.following, self._onward(None, world, mind), int(node.act is not None))
        if node.act is not None:
            self.watch(world)
        value = self._sensed(node.thing, world)
        outcome = outcome_text(value)
        if outcome not in node.branches:
            raise WrongError(f"no branch for {node.on} = {outcome}, which is the case")
        return Moved(node.branches[outcome], self._onward(value, world, mind), int(node.act is not None))

    def _sensed(self, thing: Thing, world: World) -> Value:
        if is_symbol(thing):
            return world.value(thing)  # type: ignore[arg-type]
        return all(world.holds(claim) for claim in thing)  # type: ignore[arg-type]

    def _onward(self, value: Value | None, world: World, mind: Mind | None) -> Mind | None:
        """What is known at the next node; what of it is new must be true."""
        if mind is None:
            return None
        following = self._minds.onward(mind, value)
        if following is None:
            text = "; ".join(mind.step.messages)
            raise WrongError(text or f"{value} was held to be impossible, and is the case")
        for symbol, known in following[1]:
            true = world.known.get(symbol)
            if true is not None and true != known:
                raise WrongError(f"{claim_text((symbol, known, True))} is known behind it, and is not so")
        return following[0]


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


def _check_entry(database: str, entry: Entry, world: World) -> None:
    claims = in_order(entry)
    truths = [truth(claim, world) for claim in claims]
    holding = truths.count(True)
    if (database == "Kx" and holding > 1) or (holding == 0 and None not in truths):
        raise RuledOutError
    if None in truths and (database == "Kx" or holding == 0):
        raise OpenError(claims[truths.index(None)][0])


def _check_false(truths: list[bool | None], symbols: list[Symbol]) -> None:
    if False in truths:
        return
    if None in truths:
        raise OpenError(symbols[truths.index(None)])
    raise RuledOutError
