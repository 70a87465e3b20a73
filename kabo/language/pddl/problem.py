"""Builds a Problem from the definitions of PDDL files: declarations, initial state, goal, then the actions."""

from collections.abc import Iterable, Mapping

from kabo.language import formulas as f
from kabo.language.definitions import Definition
from kabo.language.findings import Findings
from kabo.language.names import Names
from kabo.language.pddl.actions import PddlAction, Surmise, build_action, read_action
from kabo.language.pddl.conditions import read_condition
from kabo.language.pddl.declarations import read_functions, read_objects, read_predicates, read_types
from kabo.language.pddl.dialect import resolver_of
from kabo.language.pddl.forms import Form, Node, Token, read_forms
from kabo.language.pddl.initial import Initial, build_initial, read_initial
from kabo.language.pddl.sections import PddlDefinition, definitions_of
from kabo.language.problem import Domain, Problem
from kabo.language.resolver import NameResolver
from kabo.language.source import SourceFile
from kabo.language.tree_algebra import nodes, symbols
from kabo.language.types import NUMBERS
from kabo.language.vocabulary import Vocabulary


class Pddl:
    """The reader of PDDL files."""

    def definitions(self, source: SourceFile, findings: Findings) -> list[Definition]:
        """All domains and problems of a file; anything else in it is reported."""
        document = read_forms(source, findings)
        return [] if document is None else list(definitions_of(document))

    def read(
        self, domain: Definition, problem: Definition | None, findings: Findings, files: Mapping[str, str]
    ) -> Problem | None:
        """The problem of two definitions; None for a domain alone, which is only checked."""
        assert isinstance(domain, PddlDefinition)
        assert problem is None or isinstance(problem, PddlDefinition)
        return read_pddl(domain, problem, findings, files)


def read_pddl(
    domain: PddlDefinition, problem: PddlDefinition | None, findings: Findings, files: Mapping[str, str]
) -> Problem | None:
    """The problem of two definitions; None for a domain alone, which is only checked.

    Args:
        domain: the domain's definition.
        problem: the problem's, if there is one.
        findings: the collection that receives all errors; if there are any, the result must not be used.
        files: the value for `Problem.files`.
    """
    vocabulary = Vocabulary(findings)
    _declare(vocabulary, domain)
    if problem is not None:
        read_objects(resolver_of(problem.document, vocabulary, ""), problem.first(":objects"), "an object")
    schemas = _schemas(vocabulary, domain)
    if problem is None:
        _build(vocabulary, domain, schemas, Surmise(vocabulary, may_be_unknown(schemas, set())))
        return None
    at_start = resolver_of(problem.document, vocabulary, "in :init")
    initial = read_initial(at_start, _required(problem, ":init"))
    goal = _goal(resolver_of(problem.document, vocabulary, "in :goal"), _required(problem, ":goal"))
    unknown = may_be_unknown(schemas, initial.unknown_symbols())
    cost = _cost(resolver_of(problem.document, vocabulary, "in :metric"), problem.first(":metric"))
    only = cost is not None and not _asks_for(cost, schemas, goal)
    surmise = Surmise(vocabulary, frozenset(unknown), cost, only)
    built = _build(vocabulary, domain, schemas, surmise)
    vocabulary.report_renamed()
    _warn_of_disjunctions(at_start, schemas, goal, surmise)
    _check_values(vocabulary, initial, problem)
    objects = vocabulary.types_of_objects()
    effects = build_initial(vocabulary, initial, cost if only else None)
    if only:
        built.functions.pop(cost or "")  # type: ignore[attr-defined]
    name = Names().take(problem.name)
    return Problem(name, built, objects, effects, goal, {}, None, problem.document.source.path, dict(files))


def _declare(vocabulary: Vocabulary, domain: PddlDefinition) -> None:
    here = resolver_of(domain.document, vocabulary, "")
    read_types(here, domain.first(":types"))
    read_predicates(here, domain.first(":predicates"))
    read_functions(here, domain.first(":functions"))
    read_objects(here, domain.first(":constants"), "a constant")


def _required(problem: PddlDefinition, keyword: str) -> Form | None:
    section = problem.first(keyword)
    if section is None:
        problem.document.report(problem.named_at, f'a problem needs the section "{keyword}"')
    return section


def _schemas(vocabulary: Vocabulary, domain: PddlDefinition) -> list[PddlAction]:
    names, seen, schemas = Names(), set(), []
    for form in domain.actions:
        word = form.items[1]
        assert isinstance(word, Token)
        if word.text in seen:
            domain.document.report(word, f'the action "{word.text}" is defined twice')
            continue
        seen.add(word.text)
        schemas.append(read_action(domain.document, vocabulary, form, names.take(word.text)))
    return schemas


def _build(vocabulary: Vocabulary, domain: PddlDefinition, schemas: list[PddlAction], surmise: Surmise) -> Domain:
    actions = {schema.name: build_action(schema, surmise) for schema in schemas}
    mentioned = {node.name for node in nodes(tuple(actions.values())) if isinstance(node, f.Constant)}
    constants = {}
    for each in vocabulary.objects.values():  # an object that an action names is one as well
        if each.name in mentioned or (each.place is not None and _is_constant(domain, each.place)):
            constants[each.name] = each.type
    return Domain(
        Names().take(domain.name), vocabulary.types.in_order(), constants, vocabulary.predicates_of_domain(),
        vocabulary.functions_of_domain(), (), actions, domain.document.source.path, worldly=True,
    )  # fmt: skip


def _is_constant(domain: PddlDefinition, place: f.Place) -> bool:
    section = domain.first(":constants")
    if section is None or place.file != domain.document.source.name:
        return False
    end = domain.document.source.place(section.end - 1)
    return _position(domain.document.place(section)) <= _position(place) <= _position(end)


def _position(place: f.Place) -> tuple[int, int]:
    return place.line, place.column


def may_be_unknown(schemas: Iterable[PddlAction], from_start: set[str]) -> frozenset[str]:
    """The predicates and functions of which something may be unknown: at the start, or made so by an effect.

    An effect makes its outcome unknown if its condition depends on something that may be unknown.
    """
    unknown = set(from_start)
    edges = [
        (symbols((piece.condition, piece.outcome)) - {piece.symbol}, piece.symbol)
        for schema in schemas
        for piece in schema.pieces
    ]
    changed = True
    while changed:
        changed = False
        for causes, symbol in edges:
            if symbol not in unknown and causes & unknown:
                unknown.add(symbol)
                changed = True
    return frozenset(unknown)


# ------------------------------------------------------------------------------------------------- goal and metric
def _goal(here: NameResolver, section: Form | None) -> tuple[f.Formula, ...]:
    if section is None:
        return ()
    if len(section.items) != 2:
        here.report(section, f"a goal is one condition, not {len(section.items) - 1}", "join them: (and …)")
    parts = [read_condition(here, node) for node in section.rest]
    flat = [each for part in parts if part is not None for each in _conjuncts(part)]
    return tuple(flat)


def _conjuncts(formula: f.Formula) -> tuple[f.Formula, ...]:
    return formula.parts if isinstance(formula, f.And) else (formula,)


def _cost(here: NameResolver, section: Form | None) -> str | None:
    """The function (by kabo's name) whose value at the end is to be minimised."""
    if section is None:
        return None
    sense = section.items[1] if len(section.items) == 3 else None
    if not isinstance(sense, Token) or sense.text not in ("minimize", "maximize"):
        here.report(section, 'expected "(:metric minimize (total-cost))"')
        return None
    what: Node = section.items[2]
    head = what.head if isinstance(what, Form) and len(what.items) == 1 else getattr(what, "text", "")
    function = here.vocabulary.function(head)
    if sense.text == "maximize":
        here.report(sense, 'only "minimize" is supported: kabo\'s costs are added up')
    elif function is None or function.arguments or function.kind != NUMBERS:
        hint = "an action's cost is what it adds to a function without arguments, such as (total-cost)"
        here.report(what, f'the metric "{here.quote(what)}" is not supported', hint)
    else:
        return function.name
    return None


def _asks_for(symbol: str, schemas: Iterable[PddlAction], goal: tuple[f.Formula, ...]) -> bool:
    """Whether a condition or another function's value reads the symbol."""
    if symbol in symbols(goal):
        return True
    for schema in schemas:
        others = [piece.outcome for piece in schema.pieces if piece.symbol != symbol]
        conditions = [piece.condition for piece in schema.pieces]
        if symbol in symbols((schema.preconditions, others, conditions)):
            return True
    return False


# ---------------------------------------------------------------------------------------------------------- checks
def _warn_of_disjunctions(
    here: NameResolver, schemas: Iterable[PddlAction], goal: tuple[f.Formula, ...], surmise: Surmise
) -> None:
    """Warns of conditions that ask for more knowledge than PDDL does: `a or b` may be known when neither is."""
    message = "of what may be unknown, one part must be known here: PDDL asks only that some part holds"
    for formula in [*(each for schema in schemas for each in schema.preconditions), *goal]:
        waiting = [formula]
        while waiting:
            part = waiting.pop()
            if isinstance(part, f.Or | f.Exists) and not surmise.known(part):
                if part.place is not None:
                    here.findings.add(part.place, message, None, warning=True)
            elif isinstance(part, f.And):
                waiting.extend(part.parts)
            elif isinstance(part, f.Forall):
                waiting.append(part.body)


def _check_values(vocabulary: Vocabulary, initial: Initial, problem: PddlDefinition) -> None:
    """Refuses functions whose values are objects if some have none: PDDL would call them undefined."""
    given: dict[str, int] = {}
    for term in initial.values:
        given[term.function] = given.get(term.function, 0) + 1
    sorts = vocabulary.types_of_objects().values()
    for function in vocabulary.all_of("function"):
        if function.kind == NUMBERS:
            continue
        needed = 1
        for kind in function.arguments:
            needed *= sum(1 for sort in sorts if sort and vocabulary.types.fits((sort,), kind))
        if given.get(function.name, 0) < needed:
            message = f'"{function.written}" has a value for {given.get(function.name, 0)} of {needed} instances'
            hint = "give every one a value in :init; a function without a value (undefined) is not supported"
            problem.document.report(problem.first(":init") or problem.named_at, message, hint)
