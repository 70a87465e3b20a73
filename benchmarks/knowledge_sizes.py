"""How large a symbolic problem is, counted from its files alone: the measure by which families are compared.

An instance counts as one of a published family only if it has at least its objects, unknown atoms and sensing
actions. The planner leaves out what it can prove useless, so its own counts would say too little; these here read
the language only. Action instances are those whose preconditions on what no action ever changes hold at the start.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product

from kabo.language import formulas as f
from kabo.language.problem import Action, Problem

Binding = Mapping[str, str]
Ground = tuple[str, ...]  # name of a predicate or function, arguments, and a value for functions


@dataclass(frozen=True)
class Sizes:
    """Counts of one problem."""

    objects: int
    unknown_atoms: int  # in exclusive sets, disjunctions, what can be sensed, conditions of world effects
    sensing_actions: int
    ground_actions: int


@dataclass
class _Start:
    """What is said about the start; `known` holds atoms, and values of functions, that are true or false."""

    true: dict[Ground, None] = field(default_factory=dict)
    known: set[Ground] = field(default_factory=set)
    uncertain: set[Ground] = field(default_factory=set)
    index: dict[tuple[str, int, Ground], dict[str, None]] = field(default_factory=dict)

    def add(self, ground: Ground) -> None:
        """Notes what is true, and which names stand in each place of it, given the others."""
        self.true[ground] = None
        name, *arguments = ground
        for place, argument in enumerate(arguments):
            others = (*arguments[:place], *arguments[place + 1 :])
            self.index.setdefault((name, place, others), {})[argument] = None

    def value(self, term: f.Term, binding: Binding) -> str | None:
        """The name of a constant, the value of a bound variable or of a function at the start."""
        if not isinstance(term, f.Application):
            return _name(term, binding)
        name, *arguments = _ground(term, binding)
        return next(iter(self.index.get((name, len(arguments), tuple(arguments)), {})), None)


def sizes(problem: Problem) -> Sizes:
    """Counts objects, unknown atoms, sensing actions and action instances of a problem."""
    start = _Start()
    for effect in problem.initial:
        _note(problem, start, effect, {})
    changing = _changing(problem)
    actions = sensing = 0
    for action in problem.domain.actions.values():
        for binding in _instances(problem, action, changing, start):
            actions += 1
            sensing += bool(action.sense)
            for sensed in action.sense:
                start.uncertain.update(_values(problem, _ground(sensed, binding)))
            for effect in action.effects:
                start.uncertain.update(_conditions(problem, effect, binding))
    return Sizes(len(problem.objects), len(start.uncertain - start.known), sensing, actions)


# ------------------------------------------------------------------------------------------------------- the start
def _note(problem: Problem, start: _Start, effect: f.Effect, binding: Binding) -> None:
    match effect:
        case f.ForEach(variables=variables, effects=inner):
            for instance in _over(problem, variables, binding):
                for each in inner:
                    _note(problem, start, each, instance)
        case f.Change(operation="add", database="Kf", facts=facts):
            for fact in facts:
                _note_known(problem, start, fact, binding)
        case f.Change(operation="add", database="Kx" | "Kor", facts=facts):
            start.uncertain.update(member for fact in facts for member in _members(problem, fact, binding))


def _note_known(problem: Problem, start: _Start, fact: f.Fact, binding: Binding) -> None:
    match fact:
        case f.Literal(atom=atom, positive=positive):
            ground = _ground(atom, binding)
            start.known.add(ground)
            if positive:
                start.add(ground)
        case f.Comparison(operator="=", left=f.Application() as term, right=value):
            ground = _ground(term, binding)
            start.known.update(_values(problem, ground))
            start.add((*ground, _name(value, binding)))


def _members(problem: Problem, fact: f.Fact, binding: Binding) -> Iterator[Ground]:
    match fact:
        case f.Literal(atom=atom):
            yield _ground(atom, binding)
        case f.Comparison(left=f.Application() as term, right=value):
            yield (*_ground(term, binding), _name(value, binding))
        case f.ExactlyOne(variables=variables, body=body):
            for instance in _over(problem, variables, binding):
                yield from _members(problem, body, instance)


def _conditions(problem: Problem, effect: f.Effect, binding: Binding) -> Iterator[Ground]:
    match effect:
        case f.ForEach(variables=variables, effects=inner):
            for instance in _over(problem, variables, binding):
                for each in inner:
                    yield from _conditions(problem, each, instance)
        case f.WorldEffect(conditions=conditions):
            for claim in conditions:
                yield from _members(problem, claim, binding)


# ----------------------------------------------------------------------------------------------------- instances
def _changing(problem: Problem) -> set[str]:
    """Names of what an action may change or sense."""
    found: set[str] = set()

    def note(fact: object) -> None:
        match fact:
            case f.Literal(atom=atom):
                found.add(atom.predicate)
            case f.Comparison(left=f.Application(function=function)):
                found.add(function)
            case f.TermFact(term=term):
                found.add(term.function)

    def walk(effect: f.Effect) -> None:
        match effect:
            case f.ForEach(effects=inner) | f.Conditional(updates=inner):
                for each in inner:
                    walk(each)
            case f.Change(facts=facts) | f.WorldEffect(outcomes=facts):
                for fact in facts:
                    note(fact)

    for action in problem.domain.actions.values():
        for effect in action.effects:
            walk(effect)
        found.update(s.predicate if isinstance(s, f.Atom) else s.function for s in action.sense)
    return found


def _instances(problem: Problem, action: Action, changing: set[str], start: _Start) -> Iterator[Binding]:
    """The bindings of the parameters for which every precondition on what never changes holds."""
    free = [parameter for parameter in action.parameters if parameter.value_of is None]
    asked = [formula.claim for formula in action.preconditions if isinstance(formula, f.Know)]
    asked = [claim for claim in asked if not _symbols(claim) & changing]
    last = [max((k for k, p in enumerate(free) if p.name in set(_variables(c))), default=-1) for c in asked]
    ready = [[claim for claim, k in zip(asked, last, strict=True) if k == place] for place in range(len(free))]
    types = [dict.fromkeys(problem.of_type(parameter.type)) for parameter in free]

    def bind(place: int, binding: dict[str, str]) -> Iterator[Binding]:
        if place == len(free):
            yield binding
            return
        name = free[place].name
        for value in _candidates(ready[place], name, binding, start, types[place]):
            instance = {**binding, name: value}
            if all(_holds(claim, instance, start) for claim in ready[place]):
                yield from bind(place + 1, instance)

    return bind(0, {})


def _candidates(
    claims: list[f.Claim], name: str, binding: Binding, start: _Start, of_type: dict[str, None]
) -> Iterator[str]:
    """Values of a parameter: those that the first positive claim about it allows, or all of its type."""
    for claim in claims:
        if isinstance(claim, f.Literal) and claim.positive:
            arguments = claim.atom.arguments
            places = [k for k, a in enumerate(arguments) if isinstance(a, f.Variable) and a.name == name]
            if len(places) == 1:
                others = tuple(_name(a, binding) for k, a in enumerate(arguments) if k != places[0])
                found = start.index.get((claim.atom.predicate, places[0], others), {})
                return (value for value in found if value in of_type)
    return iter(of_type)


def _holds(claim: f.Claim, binding: Binding, start: _Start) -> bool:
    match claim:
        case f.Literal(atom=atom, positive=positive):
            ground = _ground(atom, binding)
            return (ground in start.true) if positive else (ground in start.known and ground not in start.true)
        case f.Comparison(operator="=" | "!=" as operator, left=left, right=right):
            sides = start.value(left, binding), start.value(right, binding)
            return None not in sides and (sides[0] == sides[1]) == (operator == "=")
    return True


# ---------------------------------------------------------------------------------------------------------- terms
def _symbols(claim: f.Claim) -> set[str]:
    """Names of the predicates and functions of a claim."""
    if isinstance(claim, f.Literal):
        return {claim.atom.predicate}
    return {side.function for side in (claim.left, claim.right) if isinstance(side, f.Application)}


def _variables(claim: f.Claim) -> Iterator[str]:
    waiting: list[f.Term] = (
        list(claim.atom.arguments) if isinstance(claim, f.Literal) else [claim.left, claim.right]
    )
    while waiting:
        term = waiting.pop()
        if isinstance(term, f.Variable):
            yield term.name
        elif isinstance(term, f.Application):
            waiting.extend(term.arguments)


def _over(problem: Problem, variables: tuple[f.Variable, ...], binding: Binding) -> Iterator[dict[str, str]]:
    for names in product(*(problem.of_type(variable.type) for variable in variables)):
        yield {**binding, **{variable.name: name for variable, name in zip(variables, names, strict=True)}}


def _ground(term: f.Atom | f.Application, binding: Binding) -> Ground:
    name = term.predicate if isinstance(term, f.Atom) else term.function
    return (name, *(_name(argument, binding) for argument in term.arguments))


def _name(term: f.Term, binding: Binding) -> str:
    match term:
        case f.Variable(name=name):
            return binding.get(name, name)
        case f.Constant(name=name):
            return name
        case f.Number(value=value):
            return repr(value)
    return "?"  # a term whose value is not known before run time


def _values(problem: Problem, ground: Ground) -> Iterator[Ground]:
    """The atom itself, or every value that a function term can take."""
    if ground[0] not in problem.domain.functions:
        yield ground
        return
    for value in problem.values_of(ground[0]) or ():
        yield (*ground, value)
