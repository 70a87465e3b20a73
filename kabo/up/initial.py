"""The initial knowledge of a problem of kabo, read off its updates: what is true, false, tied together or unknown."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product

from kabo.language import formulas as f
from kabo.language import spell
from kabo.language.problem import Problem
from kabo.language.tree_algebra import substituted


@dataclass
class Start:
    """What is known at the start; what is in none of these is unknown. `omitted` are sentences about what is not said."""

    facts: dict[f.Atom, bool] = field(default_factory=dict)
    values: dict[f.Application, f.Term] = field(default_factory=dict)
    exactly_one: list[tuple[f.Claim, ...]] = field(default_factory=list)
    at_least_one: list[tuple[f.Claim, ...]] = field(default_factory=list)
    omitted: list[str] = field(default_factory=list)
    is_uncertain: bool = False


def read_start(problem: Problem) -> Start:
    """The initial knowledge, of which only what the updates say is taken, not what follows."""
    start = Start()
    for effect in problem.initial:
        _apply(problem, start, effect)
    for members in start.exactly_one:
        _one_of(start, members)
    start.is_uncertain = any(_unknown(problem, start))
    return start


def _unknown(problem: Problem, start: Start) -> Iterator[bool]:
    """Whether something is unknown, of each predicate and each function with a list of values."""
    for name, arguments in problem.domain.predicates.items():
        known = sum(atom.predicate == name for atom in start.facts)
        yield known < sum(1 for _ in product(*map(problem.of_type, arguments)))
    for name, function in problem.domain.functions.items():
        known = sum(term.function == name for term in start.values)
        listed = problem.values_of(name)
        yield bool(listed) and known < sum(1 for _ in product(*map(problem.of_type, function.arguments)))


def _one_of(start: Start, members: tuple[f.Claim, ...]) -> None:
    """That exactly one member holds, where it is the only one that is not known to be false."""
    left = [each for each in members if not (isinstance(each, f.Literal) and start.facts.get(each.atom) is False)]
    if len(left) == 1 and isinstance(left[0], f.Literal):
        start.facts[left[0].atom] = left[0].positive


def _apply(problem: Problem, start: Start, effect: f.Effect) -> None:
    match effect:
        case f.ForEach(variables=variables, effects=effects):
            for each in effects:
                for instance in _instances(problem, variables, each):
                    _apply(problem, start, instance)
        case f.Change(operation="add", database="Kf", facts=facts):
            for fact in facts:
                _add(start, fact)
        case f.Change(operation="del", database="Kf", facts=facts):
            for fact in facts:
                if isinstance(fact, f.Literal):
                    start.facts.pop(fact.atom, None)
                elif isinstance(fact, f.Comparison) and isinstance(fact.left, f.Application):
                    start.values.pop(fact.left, None)
        case f.Change(operation="add", database="Kx" | "Kor" as database, facts=facts):
            members = tuple(_members(problem, facts))
            (start.exactly_one if database == "Kx" else start.at_least_one).append(members)
        case f.Change(operation="add", database="LCW", facts=(f.FactForall(variables, f.Literal() as body),)):
            for literal in _instances(problem, variables, body):
                start.facts.setdefault(literal.atom, not literal.positive)
        case _:
            start.omitted.append(
                f'initial knowledge "{spell(effect)}": it is about knowledge, not about the world'
            )


def _add(start: Start, fact: f.Fact) -> None:
    if isinstance(fact, f.Literal):
        start.facts[fact.atom] = fact.positive
    elif isinstance(fact, f.Comparison) and fact.operator == "=" and isinstance(fact.left, f.Application):
        start.values[fact.left] = fact.right
    else:
        start.omitted.append(f'initial knowledge "{spell(fact)}": unified-planning has no form for it')


def _members(problem: Problem, facts: tuple[f.Fact, ...]) -> Iterator[f.Claim]:
    """The members of an entry of Kx or Kor."""
    for fact in facts:
        if isinstance(fact, f.ExactlyOne | f.FactForall):
            for instance in _instances(problem, fact.variables, fact.body):
                yield from _members(problem, (instance,))
        elif isinstance(fact, f.Literal | f.Comparison):
            yield fact


def _instances(problem: Problem, variables: tuple[f.Variable, ...], tree: "f.Effect | f.Fact") -> Iterator:  # type: ignore[type-arg]
    """The tree with every combination of objects for its variables."""
    for names in product(*(problem.of_type(each.type) for each in variables)):
        binding: dict[str, f.Term] = {
            each.name: f.Constant(name) for each, name in zip(variables, names, strict=True)
        }
        yield substituted(tree, binding)
