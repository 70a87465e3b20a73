"""A problem of kabo as one of unified-planning, for its plans: with the same actions, objects and fluents.

unified-planning describes the world, kabo what is known, too. Preconditions, effects and initial knowledge that it has
no form for are left out, and each of them is named: with nothing left out, the problem says the same, and its plans can
be judged there. Of motions it says nothing: they stay in kabo's plan.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from unified_planning.environment import get_environment
from unified_planning.exceptions import UPException
from unified_planning.model import ContingentProblem, Fluent, InstantaneousAction, Object, SensingAction
from unified_planning.model import Problem as UPProblem

from kabo.language import formulas as f
from kabo.language import spell
from kabo.language.names import Names as Namespace
from kabo.language.problem import Action, Problem
from kabo.up.initial import Start, read_start
from kabo.up.names import Names
from kabo.up.problems import Translation
from kabo.up.sayable import Beyond, Sayer

MAX_HIDDEN = 20_000  # fluents about which something is unknown


@dataclass(frozen=True)
class Export:
    """A problem of kabo in unified-planning: `translation` joins both; `omitted` are sentences, one for each loss."""

    translation: Translation
    omitted: tuple[str, ...]


def problem_to_up(problem: Problem, environment: Any = None) -> Export:
    """The problem of unified-planning in which kabo's plans for `problem` can be written down.

    Args:
        problem: any problem of kabo; of a scene nothing is said, of procedures only that they are left out.
        environment: of unified-planning; the global one if none is given.
    """
    return _Exporter(problem, environment or get_environment()).export()


@dataclass
class _Exporter:
    problem: Problem
    environment: Any
    omitted: list[str] = field(default_factory=list)
    names: Names = field(default_factory=Names)
    values: dict[str, dict[str, Any]] = field(default_factory=dict)

    def export(self) -> Export:
        """Declarations, the start, the actions, the goal; what is lost is named on the way."""
        domain = self.problem.domain
        start = read_start(self.problem)
        self.omitted += start.omitted
        contingent = start.is_uncertain or any(each.sense for each in domain.actions.values())
        kind = ContingentProblem if contingent else UPProblem
        self.made = kind(self.problem.name, self.environment)
        self.names.title = self.problem.name
        self.space = Namespace()
        self._declare()
        for action in domain.actions.values():
            self.made.add_action(self._action(action))
        for rule in domain.update_rules:
            self.omitted.append(f'update rule "{spell(rule)}": unified-planning has none')
        for goal in self.problem.goal:
            self._try(f'goal "{spell(goal)}"', self._goal, goal)
        self._start(start)
        return Export(Translation(self.made, self.problem, self.names, exact=False), tuple(self.omitted))

    def _try(self, what: str, do: Callable[..., object], *arguments: Any) -> None:
        """Does something, or names what is left out."""
        try:
            do(*arguments)
        except Beyond as error:
            self.omitted.append(f"{what}: {error}")
        except UPException as error:
            self.omitted.append(f"{what}: {' '.join(str(error).split())}")

    # ------------------------------------------------------------------------------------------------- declarations
    def _declare(self) -> None:
        problem, domain = self.problem, self.problem.domain
        manager = self.environment.type_manager
        objects = {name: self.space.take(name) for name in problem.objects}
        fluents = {name: self.space.take(name) for name in (*domain.predicates, *domain.functions)}
        types: dict[str, Any] = {}
        for name, parent in domain.types.items():
            original = self.space.take(name)
            types[name] = manager.UserType(original, None if parent is None else types[parent])
            self.names.types[original] = name
        made = {}
        for name, kind in problem.objects.items():
            made[name] = Object(objects[name], types[kind], self.environment)
            self.names.objects[objects[name]] = name
            self.made.add_object(made[name])
        declared = {}
        for name, arguments in domain.predicates.items():
            declared[name] = self._fluent(fluents[name], manager.BoolType(), arguments, types)
        for name, function in domain.functions.items():
            kind = manager.RealType() if function.value_type is None else types[function.value_type]
            if function.values is not None:
                kind = self._enumeration(name, function.values)
            declared[name] = self._fluent(fluents[name], kind, function.arguments, types)
        self.names.fluents |= {original: name for name, original in fluents.items()}
        self.sayer = Sayer(self.environment.expression_manager, types, declared, made, self.values, {})

    def _fluent(self, name: str, kind: Any, arguments: tuple[str, ...], types: dict[str, Any]) -> Any:
        signature = OrderedDict((f"a{number}", types[each]) for number, each in enumerate(arguments))
        fluent = Fluent(name, kind, signature, self.environment)
        self.made.add_fluent(fluent)
        return fluent

    def _enumeration(self, function: str, values: tuple[str, ...]) -> Any:
        """A type whose objects are the listed values of a function."""
        kind = self.environment.type_manager.UserType(self.space.take(f"value_of_{function}"))
        self.values[function] = {}
        for value in values:
            made = Object(self.space.take(value), kind, self.environment)
            self.values[function][value] = made
            self.names.objects[made.name] = value
            self.made.add_object(made)
        return kind

    # ------------------------------------------------------------------------------------------------------ actions
    def _action(self, action: Action) -> Any:
        original = self.space.take(action.name)
        self.names.actions[original] = action.name
        kinds = OrderedDict((each.name, self._kind_of(action, each.type)) for each in action.parameters)
        made = (SensingAction if action.sense else InstantaneousAction)(original, kinds, self.environment)
        manager = self.sayer.manager
        scope = {each.name: manager.ParameterExp(made.parameter(each.name)) for each in action.parameters}
        here = Sayer(manager, self.sayer.types, self.sayer.fluents, self.sayer.objects, self.values, scope)
        what = f"action {action.name}"
        for each in action.preconditions:
            self._try(
                f'{what}, precondition "{spell(each)}"',
                lambda part: made.add_precondition(here.formula(part)),
                each,
            )
        for effect in action.effects:
            self._try(f'{what}, effect "{spell(effect)}"', _add_effects, made, here, effect)
        for sensed in action.sense:
            said = here.atom(sensed) if isinstance(sensed, f.Atom) else here.term(sensed)
            made.add_observed_fluent(said)
        return made

    def _kind_of(self, action: Action, name: str) -> Any:
        """The type of a parameter; a run-time variable may have one that is an enumeration."""
        if name in self.sayer.types:
            return self.sayer.types[name]
        for each in action.parameters:
            if each.type == name and each.value_of is not None:
                return self.sayer.fluents[each.value_of.function].type
        raise Beyond(f'parameters of action "{action.name}" are no objects')

    # ------------------------------------------------------------------------------------------- goal and initial state
    def _goal(self, goal: f.Formula) -> None:
        said = self.sayer.formula(goal)
        if isinstance(goal, f.Temporal):
            self.made.add_state_invariant(said.arg(0))
        else:
            self.made.add_goal(said)

    def _start(self, start: Start) -> None:
        manager, domain = self.sayer.manager, self.problem.domain
        hidden = 0
        for name, arguments in domain.predicates.items():
            for constants in self._instances(arguments):
                atom = f.Atom(name, constants)
                known = start.facts.get(atom)
                if known is not None:
                    self.made.set_initial_value(self.sayer.atom(atom), manager.Bool(known))
                elif hidden < MAX_HIDDEN:
                    hidden += 1
                    self.made.add_unknown_initial_constraint(self.sayer.atom(atom))
        for name, function in domain.functions.items():
            for constants in self._instances(function.arguments):
                self._start_value(start, f.Application(name, constants))
        for members in start.exactly_one:
            self.made.add_oneof_initial_constraint([self.sayer.claim(each) for each in members])
        for members in start.at_least_one:
            self.made.add_or_initial_constraint([self.sayer.claim(each) for each in members])
        if hidden == MAX_HIDDEN:
            self.omitted.append(
                f"initial knowledge: more than {MAX_HIDDEN} atoms are unknown, the rest is not named"
            )

    def _start_value(self, start: Start, term: f.Application) -> None:
        said, value = self.sayer.term(term), start.values.get(term)
        listed = self.problem.values_of(term.function)
        if value is not None:
            self.made.set_initial_value(said, self.sayer.term(value, term.function))
        elif listed is None:
            self.omitted.append(f'initial knowledge: "{spell(term)}" is an unknown number')
        elif listed:
            self.made.add_oneof_initial_constraint(
                [self.sayer.claim(f.Comparison("=", term, f.Constant(each))) for each in listed]
            )

    def _instances(self, arguments: tuple[str, ...]) -> Iterator[tuple[f.Constant, ...]]:
        domains = [self.problem.of_type(each) for each in arguments]
        return (tuple(map(f.Constant, names)) for names in product(*domains))


def _add_effects(action: Any, here: Sayer, effect: f.Effect) -> None:
    """Adds the effects of unified-planning that an effect of kabo becomes: all of them, or none."""
    for each in list(here.assignments(effect)):
        action.add_effect(each.fluent, each.value, each.condition, forall=each.variables)
