"""Instances of action schemas: parameters are bound one after the other, and pruned as soon as a precondition is false.

Parts that do not depend on a parameter are compiled once for all its values: `forall(object o) (K(one_below(this) = o)
=> add(Kf, highest(o)))` is compiled once for each `this`, not once for each pair of arguments.
"""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from kabo.knowledge.actions import RunTimeArgument
from kabo.knowledge.binding import Binding
from kabo.knowledge.grounding.compiler import Compiler
from kabo.knowledge.grounding.effects import Sensed, WorldUpdate, compile_effects, compile_sensing
from kabo.knowledge.grounding.statics import StaticFacts
from kabo.knowledge.grounding.worldly import compile_world_effects
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import FALSE, TRUE, Query, conjunction
from kabo.knowledge.runtime import without_runtime_variables
from kabo.language import spell_bound
from kabo.language.formulas import Effect, Formula, GroundCall, Literal, Term, Variable
from kabo.language.problem import Action, Problem

Result = TypeVar("Result")


class ActionInstance(NamedTuple):
    """An instance of an action schema whose updates are not sorted by kind yet.

    `updates` are all its updates: those in `plain` are made from changes of knowledge, the others from the world
    effects `worlds`.
    """

    name: str
    arguments: Mapping[str, str | RunTimeArgument]
    call: GroundCall | None
    sense: tuple[str, ...]
    precondition: Query
    updates: tuple[Update, ...]
    cost: float
    plain: tuple[Update, ...] = ()
    worlds: tuple[WorldUpdate, ...] = ()


class SchemaGrounder:
    """Grounds one action schema; remembers the parts of the schema that have been compiled so far."""

    def __init__(self, compiler: Compiler, statics: StaticFacts, action: Action) -> None:
        self.compiler, self.statics, self.declared = compiler, statics, action
        self.action = without_runtime_variables(action)
        self._memo: dict[Hashable, Any] = {}
        self._free = {
            id(part): free_variables(part)
            for part in (*self.action.preconditions, *self.action.effects, *self.action.sense, self.action.cost)
        }

    def instances(self) -> Iterator[ActionInstance]:
        """All instances whose static preconditions hold, in the order in which their arguments are declared."""
        names = [parameter.name for parameter in self.action.parameters]
        objects = [self._places(parameter.type) for parameter in self.action.parameters]
        joins, ready = self._preconditions_by_parameter()

        def bind(position: int, binding: dict[str, str], known: Query) -> Iterator[ActionInstance]:
            queries = [self._query(formula, binding) for formula in ready[position]]
            known = conjunction([known, *queries]) if queries else known
            if known == FALSE:
                return
            if position == len(names):
                yield self._instance(binding, known)
                return
            name = names[position]
            allowed = [self.statics.values(literal, name, binding) for literal in joins[position]]
            for value in _common(objects[position], allowed):
                yield from bind(position + 1, {**binding, name: value}, known)

        return bind(0, {}, TRUE)

    def _places(self, kind: str) -> Mapping[str, int]:
        """The objects of a type, each with its position in the order of declaration."""
        return {name: place for place, name in enumerate(self.compiler.of_type(kind))}

    def _preconditions_by_parameter(self) -> tuple[list[list[Literal]], list[list[Formula]]]:
        """Preconditions by the number of parameters that must be bound first: static literals, and others.

        A static literal lists the possible values of the last of its parameters.
        """
        places = {parameter.name: number for number, parameter in enumerate(self.action.parameters, start=1)}
        ready: list[list[Formula]] = [[] for _ in range(len(places) + 1)]
        joins: list[list[Literal]] = [[] for _ in range(len(places) + 1)]
        for formula in self.action.preconditions:
            place = max((places.get(name, 0) for name in self._free[id(formula)]), default=0)
            literal = self.statics.join(formula)
            if literal is not None and place:
                joins[place - 1].append(literal)
            else:
                ready[place].append(formula)
        return joins, ready

    def _once(
        self, part: Effect | Formula | Sensed | Term, binding: Binding, compile_: Callable[[], Result]
    ) -> Result:
        """The compiled part; it is compiled once for the same values of its own variables."""
        key = id(part), tuple([binding[name] for name in self._free[id(part)] if name in binding])
        if key not in self._memo:
            self._memo[key] = compile_()
        return self._memo[key]  # type: ignore[no-any-return]

    def _query(self, formula: Formula, binding: Binding) -> Query:
        return self._once(formula, binding, lambda: self.compiler.query(formula, binding))

    def _instance(self, binding: Binding, precondition: Query) -> ActionInstance:
        action, compiler = self.action, self.compiler
        updates, sense, plain, worlds = self._effects(binding)
        call = None if action.geometry is None else action.geometry.ground(binding)
        arguments = {
            p.name: binding[p.name] if p.value_of is None else RunTimeArgument(spell_bound(p.value_of, binding))
            for p in self.declared.parameters
        }
        cost = self._once(
            action.cost, binding, lambda: compiler.number(action.cost, binding).value(compiler.static)
        )
        cost = 1.0 if cost is None else cost
        return ActionInstance(action.name, arguments, call, sense, precondition, updates, cost, plain, worlds)

    def _effects(
        self, binding: Binding
    ) -> tuple[tuple[Update, ...], tuple[str, ...], tuple[Update, ...], tuple[WorldUpdate, ...]]:
        """All updates, the sensed facts as text, the updates of knowledge, the world effects; equal parts are shared."""
        compiler = self.compiler
        parts: list[Update | WorldUpdate] = []
        for effect in self.action.effects:
            parts += self._once(effect, binding, lambda e=effect: tuple(compile_effects(compiler, [e], binding)))  # type: ignore[misc]
        for sensed in self.action.sense:
            parts.append(self._once(sensed, binding, lambda s=sensed: compile_sensing(compiler, s, binding)))  # type: ignore[misc]
        key = tuple(map(id, parts))
        if key not in self._memo:
            plain = tuple(part for part in parts if isinstance(part, Update))
            updates = list(plain)
            worlds = [part for part in parts if isinstance(part, WorldUpdate)]
            updates += list(compile_world_effects(compiler, worlds, updates)) if worlds else []
            sense = dict.fromkeys(update.entry.text for update in updates if update.entry is not None)
            self._memo[key] = tuple(updates), tuple(sense), plain, tuple(worlds)
        return self._memo[key]  # type: ignore[no-any-return]


def action_instances(compiler: Compiler, problem: Problem) -> Iterator[ActionInstance]:
    """The instances of all action schemas of a problem, in the order of the file."""
    statics = StaticFacts(compiler)
    for action in problem.domain.actions.values():
        yield from SchemaGrounder(compiler, statics, action).instances()


def _common(objects: Mapping[str, int], allowed: Sequence[Mapping[str, None]]) -> Iterable[str]:
    """The objects that all joins allow, in the order of declaration; it begins with the join that allows fewest."""
    if not allowed:
        return objects
    fewest = min(allowed, key=len)
    found = [value for value in fewest if value in objects and all(value in values for values in allowed)]
    return sorted(found, key=objects.__getitem__)


def free_variables(tree: object) -> tuple[str, ...]:
    """The names of all variables in a tree, each once, in the order of their first occurrence."""
    return tuple(dict.fromkeys(variable.name for variable in variables_in(tree)))


def variables_in(tree: object) -> Iterator[Variable]:
    """Every occurrence of a variable anywhere in a tree, in order."""
    if isinstance(tree, Variable):
        yield tree
    elif isinstance(tree, tuple):
        for part in tree:
            yield from variables_in(part)
    elif hasattr(tree, "__dataclass_fields__"):
        for name in tree.__dataclass_fields__:
            if name != "place":
                yield from variables_in(getattr(tree, name))
