"""Grounds a problem into a task with only the actions that could ever apply and the facts that occur in it."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import prod

from kabo.knowledge.actions import Branching, GroundAction, branching_of
from kabo.knowledge.binding import Binding
from kabo.knowledge.closure import AlwaysMonitor, Closure, Rule, UnitPropagator
from kabo.knowledge.entries import Entry, LastValue
from kabo.knowledge.facts import Claim, ConjunctionBits, TermBits, open_entries
from kabo.knowledge.grounding.compiler import Compiler
from kabo.knowledge.grounding.contradictions import explained, has_world, refuse_opposites
from kabo.knowledge.grounding.effects import compile_effects
from kabo.knowledge.grounding.schemas import ActionInstance, action_instances
from kabo.knowledge.grounding.symbols import Symbols, pieces_of, symbols_of
from kabo.knowledge.grounding.temporal import TemporalGoals
from kabo.knowledge.grounding.unsupported import refuse_unsupported
from kabo.knowledge.progression import Lexicon, Update, effects_of
from kabo.knowledge.queries import FALSE, TRUE, Query, bits_of, conjunction, tested_for_zero, union
from kabo.knowledge.reachability import Reach, relaxed_reach
from kabo.knowledge.relevance import Relevance
from kabo.knowledge.task import GoalPart, GroundedTask
from kabo.language import spell_bound
from kabo.language.formulas import And, Change, Forall, Formula, WorldEffect
from kabo.language.problem import Problem


@dataclass(frozen=True)
class Grounding:
    """A grounded problem that still contains unreachable actions and facts, for explanations.

    `actions` are all actions whose static preconditions hold; `asked` are the bits that conditions of effects read.
    """

    compiler: Compiler
    initial: int
    actions: tuple[GroundAction, ...]
    goal: tuple[GoalPart, ...]
    rules: tuple[Rule, ...]
    closure: Closure
    splits: Mapping[int, Branching]  # on every atom and term that allows branching
    branchings: Mapping[int, Branching]  # those that one of `actions` can open
    reach: Reach
    asked: int
    instances: tuple[ActionInstance, ...]  # what each of `actions` was compiled from, in the same order


def ground(problem: Problem) -> GroundedTask:
    """Grounds a problem whose names have been checked.

    Actions are in the order of the file, then of the declaration of their arguments. Actions and facts that the delete
    relaxation cannot reach are left out.

    Raises:
        InputError: the problem uses something that kabo does not support (with every such place), its initial
            knowledge contradicts itself, or its update rules do not reach a fixpoint.
    """
    whole = ground_whole(problem, by_layers=False)
    compiler, closure, goal, actions = whole.compiler, whole.closure, whole.goal, whole.actions
    if len(whole.reach.actions) < len(actions):
        actions = tuple(replace(action, index=index) for index, action in enumerate(whole.reach.actions))
    branchings = _open(whole.splits, compiler.fluents.whether, whole.initial, actions, whole.rules)
    query = conjunction(part.query for part in goal)
    return GroundedTask(
        initial=whole.initial,
        actions=actions,
        goal=goal,
        goal_query=query,
        entries={group.whether: group.text for group in compiler.fluents},
        whether=compiler.fluents.whether,
        branchings=branchings,
        pending=union(branchings),
        relevance=Relevance(actions, query, branchings, closure, [group.mask for group in compiler.fluents]),
        closure=closure,
        may_wait=bool(
            _learned(branchings, closure) & (whole.asked | _denied(actions, query, closure))
            or (branchings and closure.rules)
        ),
        groups=tuple(compiler.fluents),
        functional=union(group.known for group in compiler.fluents if isinstance(group, TermBits)),
        width=compiler.fluents.width,
    )


def ground_whole(problem: Problem, *, by_layers: bool = True) -> Grounding:
    """Grounds a problem and keeps the actions and facts that its delete relaxation cannot reach.

    Without `by_layers` this is faster, but the relaxation is not computed layer by layer.

    Raises:
        InputError: the problem uses something that kabo does not support, its initial knowledge contradicts
            itself, or its update rules do not reach a fixpoint.
    """
    refuse_unsupported(problem)
    refuse_opposites(problem)
    try:
        return _ground(problem, by_layers)
    except _Contradiction:
        raise explained(problem, _contradicts) from None


def _ground(problem: Problem, by_layers: bool) -> Grounding:
    compiler = Compiler(problem, _symbols(problem))
    state, permanent = _initial_state(compiler)
    found = list(action_instances(compiler, problem))
    asked = compiler.asked
    rules = tuple(_rules(compiler))
    temporal = TemporalGoals(compiler)
    goal = tuple(_goal_parts(compiler, problem.goal, {}))
    state, copies = temporal.bind(state)
    closure = _closure(compiler, [*permanent, *copies], rules, temporal.monitors)
    initial = closure.complete(state | union(monitor.held for monitor in temporal.monitors), -1)
    if initial is None or not has_world(initial, _tied(closure, initial)):
        raise _Contradiction
    lexicon = Lexicon.of(compiler.fluents, compiler.entries.values())
    actions = tuple(_action(instance, index, lexicon, closure) for index, instance in enumerate(found))
    splits = _branchings(compiler, closure)
    branchings = _open(splits, compiler.fluents.whether, initial, actions, rules)
    reach = relaxed_reach(initial, actions, branchings, closure, by_layers=by_layers)
    return Grounding(
        compiler, initial, actions, goal, rules, closure, splits, branchings, reach, asked, tuple(found)
    )


def _symbols(problem: Problem) -> Symbols:
    """The symbols that change; conditions of world effects do not if every instance is known from the beginning."""
    symbols = symbols_of(problem)
    candidates = symbols.causes - symbols.changing
    if candidates:
        compiler = Compiler(problem, symbols)
        _initial_state(compiler)
        unknown = {name for name in candidates if not _is_complete(compiler, name)}
        symbols = replace(symbols, changing=symbols.changing | unknown)
    return symbols


def _is_complete(compiler: Compiler, name: str) -> bool:
    """Whether every instance of a static symbol is known."""
    problem, domain = compiler.problem, compiler.problem.domain
    kinds = domain.predicates[name] if name in domain.predicates else domain.functions[name].arguments
    known = sum(
        1
        for _, _, group in compiler.statics.named(name)
        if compiler.statics.key_of(group)[0] == name and group.known & compiler.static
    )
    return known == prod(len(problem.of_type(kind)) for kind in kinds)


def _action(instance: ActionInstance, index: int, lexicon: Lexicon, closure: Closure) -> GroundAction:
    effects = effects_of(instance.updates, lexicon)
    return GroundAction(
        instance.name,
        instance.arguments,
        instance.call,
        instance.sense,
        instance.precondition,
        effects,
        closure,
        index,
        instance.cost,
    )


def _initial_state(compiler: Compiler) -> tuple[int, list[Entry]]:
    """The state after the updates of `initial`, one after the other and not closed yet, and the permanent entries.

    Entries whose members no action changes are permanent. Static knowledge is kept in the compiler, not in the state.
    """
    state = 0
    deletes = any(
        isinstance(piece, Change) and piece.operation == "del" and piece.database in ("Kx", "Kor")
        for piece in pieces_of(compiler.problem.initial)
    )
    compiler.starting = not deletes
    for effect in compiler.problem.initial:
        updates = list(compile_effects(compiler, [effect], {}))
        if any(isinstance(update, Update) and update.condition != TRUE for update in updates):
            state = _closed(compiler, state)  # a local closed world depends on what is known, inferences included
        for update in updates:
            assert isinstance(update, Update), "the language allows no world effect here"
            if update.static:
                compiler.static = _applied(compiler.static, update)
            else:
                state = _applied(state, update)
    compiler.starting = False
    last_values = [LastValue(g) for g in compiler.statics if isinstance(g, TermBits) and g.unequal]
    static = Closure(last_values).complete(compiler.static, -1)
    if static is None:
        raise _Contradiction
    compiler.static = static
    return state, [entry for entry in compiler.entries.values() if not entry.active]


def _closed(compiler: Compiler, state: int) -> int:
    permanent = [entry for entry in compiler.entries.values() if not entry.active]
    closed = _closure(compiler, permanent, list(_rules(compiler)), ()).complete(state, -1)
    return state if closed is None else closed


def _applied(state: int, update: Update) -> int:
    if update.assignment is None:
        return state & ~update.clear | update.make if update.condition.holds(state) else state
    after = effects_of([update], Lexicon()).after(state)
    return state if after is None else after


class _Contradiction(Exception):
    """Raised within this file when the initial knowledge contradicts itself."""


def _contradicts(problem: Problem) -> bool:
    """Whether the initial knowledge contradicts itself."""
    try:
        compiler = Compiler(problem, _symbols(problem))
        state, permanent = _initial_state(compiler)
        closure = _closure(compiler, permanent, tuple(_rules(compiler)), ())
        initial = closure.complete(state, -1)
    except _Contradiction:
        return True
    return initial is None or not has_world(initial, _tied(closure, initial))


def _tied(closure: Closure, initial: int) -> Iterator[tuple[Entry, tuple[Claim, ...]]]:
    """The entries of the initial state, each with its members that are not known to be false."""
    for entry in closure.propagators:
        if isinstance(entry, Entry) and (not entry.active or entry.active & initial):
            members = tuple(member for member in entry.members if not initial & member.fails)
            if entry.exactly or not any(initial & member.holds for member in members):
                yield entry, members


def _closure(
    compiler: Compiler, permanent: Iterable[Entry], rules: Iterable[Rule], monitors: Iterable[AlwaysMonitor]
) -> Closure:
    propagators: list[UnitPropagator] = [*permanent, *(e for e in compiler.entries.values() if e.active)]
    propagators += [LastValue(g) for g in compiler.fluents if isinstance(g, TermBits) and g.unequal]
    exclusive = {m: None for ms in Lexicon.of(compiler.fluents).contradictions.values() for m in ms}
    return Closure(propagators, list(rules), list(monitors), exclusive)


def _rules(compiler: Compiler) -> Iterator[Rule]:
    """The ground update rules without those that can never fire."""
    compiler.inferring = True
    compiled = [
        (effect, list(compile_effects(compiler, [effect], {}))) for effect in compiler.problem.domain.update_rules
    ]
    compiler.inferring = False
    contradictions = Lexicon.of(compiler.fluents).contradictions
    for effect, updates in compiled:
        place = effect.place if isinstance(effect, Change | WorldEffect) else getattr(effect, "place", None)
        for update in updates:
            assert isinstance(update, Update), "the language allows no world effect in rules"
            if update.condition != FALSE and update.writes:
                masks = [mask for bit in bits_of(update.make) for mask in contradictions.get(bit, ())]
                yield Rule(update.condition, update.clear, update.make, union(masks) & ~update.make, place)


def _open(
    splits: Mapping[int, Branching],
    whether: int,
    initial: int,
    actions: Iterable[GroundAction],
    rules: Iterable[Rule],
) -> dict[int, Branching]:
    """The branchings on entries that the initial state has or that an action or rule may add."""
    entered = open_entries(initial, whether)
    updates = {id(update): update for action in actions for update in action.effects.updates}  # actions share many
    entered |= union(open_entries(update.make, whether) for update in updates.values())
    for rule in rules:
        entered |= open_entries(rule.make, whether)
    return {entry: split for entry, split in splits.items() if entry & entered}


def _learned(branchings: Mapping[int, Branching], closure: Closure) -> int:
    """The bits that outcomes of branchings may set."""
    made = union(choice.make for split in branchings.values() for choice in split.choices)
    return made & ~union(branchings) | closure.makes if branchings else 0


def _denied(actions: Iterable[GroundAction], goal: Query, closure: Closure) -> int:
    """The bits that may have to be 0 for a precondition, rule, monitor or goal to hold, and those that inference clears."""
    asked = [goal, *(action.precondition for action in actions)]
    asked += [rule.condition for rule in closure.rules] + [monitor.condition for monitor in closure.monitors]
    return union(tested_for_zero(query) for query in asked) | closure.clears


def _goal_parts(compiler: Compiler, goal: tuple[Formula, ...], binding: Binding) -> Iterator[GoalPart]:
    for formula, bound in conjuncts(compiler, goal, binding):
        yield GoalPart(spell_bound(formula, bound), compiler.query(formula, bound))


def conjuncts(
    compiler: Compiler, formulas: tuple[Formula, ...], binding: Binding
) -> Iterator[tuple[Formula, Binding]]:
    """Each conjunct with its binding; only outermost conjunctions and universal quantifiers are taken apart."""
    for formula in formulas:
        match formula:
            case And(parts=parts):
                yield from conjuncts(compiler, parts, binding)
            case Forall(variables=variables, body=body):
                for instance in compiler.instances(variables, binding):
                    yield from conjuncts(compiler, (body,), instance)
            case _:
                yield formula, binding


def _branchings(compiler: Compiler, closure: Closure) -> dict[int, Branching]:
    entry_of = {
        group.text: compiler.entry(False, [part.denied for part in group.parts])
        for group in compiler.fluents
        if isinstance(group, ConjunctionBits)
    }
    found = (branching_of(group, closure, entry_of) for group in compiler.fluents)
    return {branching.entry: branching for branching in found if branching is not None}
