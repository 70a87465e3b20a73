"""From a problem to a grounded task: only actions that could ever apply, only facts that are mentioned."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from kabo.knowledge.actions import Branching, GroundAction, branching_of
from kabo.knowledge.compiler import Binding, Compiler, ground_call
from kabo.knowledge.effects import compile_effects, compile_sensing
from kabo.knowledge.progression import Update, effects_of
from kabo.knowledge.queries import FALSE, TRUE, Query, conjunction, union
from kabo.knowledge.reachability import relaxed_reach
from kabo.knowledge.refusals import refuse_unsupported
from kabo.knowledge.relevance import Relevance
from kabo.knowledge.symbols import symbols_of
from kabo.knowledge.task import GoalPart, Task
from kabo.knowledge.text import formula_text
from kabo.language.formulas import And, Forall, Formula, Variable
from kabo.language.problem import Action, Problem


def ground(problem: Problem) -> Task:
    """Grounds a problem whose names have been checked.

    Actions keep the order of the file, their arguments the order of declaration; what the delete relaxation
    cannot reach is left out.

    Raises:
        InputError: the problem uses what this planner does not support yet; names every such place.
    """
    refuse_unsupported(problem)
    compiler = Compiler(problem, symbols_of(problem))
    initial = _initial_state(compiler)
    actions = _numbered(a for schema in problem.domain.actions.values() for a in _instances(compiler, schema))
    goal = tuple(_goal_parts(compiler, problem.goal, {}))
    reach = relaxed_reach(initial, actions, _branchings(compiler))
    actions = _numbered(reach.actions)
    branchings = {entry: split for entry, split in _branchings(compiler).items() if entry & reach.ones}
    query = conjunction(part.query for part in goal)
    return Task(
        initial=initial,
        actions=actions,
        goal=goal,
        goal_query=query,
        entries={group.entry: group.text for group in compiler.fluents},
        entry_mask=union(group.entry for group in compiler.fluents),
        branchings=branchings,
        pending=union(branchings),
        relevance=Relevance(actions, query, branchings, [group.mask for group in compiler.fluents]),
        width=compiler.fluents.width,
    )


def _numbered(actions: Iterable[GroundAction]) -> tuple[GroundAction, ...]:
    return tuple(replace(action, index=index) for index, action in enumerate(actions))


def _initial_state(compiler: Compiler) -> int:
    """Empty knowledge after the updates of `initial`, one after the other; keeps static knowledge apart."""
    state = 0
    for effect in compiler.problem.initial:
        static: list[Update] = []
        fluent: list[Update] = []
        for update in compile_effects(compiler, [effect], {}):
            (fluent if update.group in compiler.fluents else static).append(update)
        compiler.static = _applied(compiler.static, static)
        state = _applied(state, fluent)
    return state


def _applied(state: int, updates: list[Update]) -> int:
    for update in updates:
        after = effects_of([update]).after(state)
        state = state if after is None else after
    return state


def _goal_parts(compiler: Compiler, goal: tuple[Formula, ...], binding: Binding) -> Iterator[GoalPart]:
    """The goal's conjuncts, with conjunctions and universal quantifiers at the top taken apart."""
    for formula in goal:
        match formula:
            case And(parts=parts):
                yield from _goal_parts(compiler, parts, binding)
            case Forall(variables=variables, body=body):
                for instance in compiler.instances(variables, binding):
                    yield from _goal_parts(compiler, (body,), instance)
            case _:
                yield GoalPart(formula_text(formula, binding), compiler.query(formula, binding))


def _branchings(compiler: Compiler) -> dict[int, Branching]:
    found = (branching_of(group) for group in compiler.fluents)
    return {branching.entry: branching for branching in found if branching is not None}


def _instances(compiler: Compiler, schema: Action) -> Iterator[GroundAction]:
    """All instances of an action whose static preconditions hold, arguments in the order of declaration."""
    ready = _preconditions_by_parameter(schema)
    names = [parameter.name for parameter in schema.parameters]
    objects = [compiler.problem.of_type(parameter.type) for parameter in schema.parameters]

    def bind(position: int, binding: dict[str, str], known: Query) -> Iterator[GroundAction]:
        known = conjunction([known, *(compiler.query(formula, binding) for formula in ready[position])])
        if known == FALSE:
            return
        if position == len(names):
            yield _ground_action(compiler, schema, binding, known)
            return
        for name in objects[position]:
            yield from bind(position + 1, {**binding, names[position]: name}, known)

    return bind(0, {}, TRUE)


def _preconditions_by_parameter(schema: Action) -> list[list[Formula]]:
    """Preconditions sorted by how many parameters must be bound before they can be compiled."""
    places = {parameter.name: number for number, parameter in enumerate(schema.parameters, start=1)}
    ready: list[list[Formula]] = [[] for _ in range(len(places) + 1)]
    for formula in schema.preconditions:
        ready[max((places.get(name, 0) for name in _variables(formula)), default=0)].append(formula)
    return ready


def _variables(tree: object) -> Iterator[str]:
    """The names of all variables anywhere in a formula tree."""
    if isinstance(tree, Variable):
        yield tree.name
    elif isinstance(tree, tuple):
        for part in tree:
            yield from _variables(part)
    elif hasattr(tree, "__dataclass_fields__"):
        for name in tree.__dataclass_fields__:
            if name != "place":
                yield from _variables(getattr(tree, name))


def _ground_action(compiler: Compiler, schema: Action, binding: Binding, precondition: Query) -> GroundAction:
    sensing = [compile_sensing(compiler, sensed, binding) for sensed in schema.sense]
    updates = [*compile_effects(compiler, schema.effects, binding), *sensing]
    call = None if schema.geometry is None else ground_call(schema.geometry, binding)
    sense = tuple(dict.fromkeys(update.group.text for update in updates if _makes_entry(update)))
    return GroundAction(schema.name, dict(binding), call, sense, precondition, effects_of(updates), 0)


def _makes_entry(update: Update) -> bool:
    """Whether the update says that something will be known at run time."""
    return bool(update.make & update.group.entry)
