"""Domain files: types, constants, predicates, functions, procedures, update rules and actions.

Source: docs/reference/files.md#domain-files.
"""

import os
from collections.abc import Callable, Iterator
from collections.abc import Mapping as MappingType
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeVar

from kabo.language import formulas as f
from kabo.language.expressions import Expression
from kabo.language.findings import Findings
from kabo.language.problem import Action, Domain, Function, Parameter, Procedure
from kabo.language.resolver import NameResolver
from kabo.language.types import ANY, NUMBER, NUMBERS, TEST, Kind, Values, type_of
from kabo.language.vocabulary import Symbol, Vocabulary
from kabo.language.yaml.calls import read_call
from kabo.language.yaml.dialect import YAML, report_unknown
from kabo.language.yaml.documents import Mapping, Scalar, Sequence, YamlNode
from kabo.language.yaml.effects import read_effects
from kabo.language.yaml.procedures import ProcedureSignatures
from kabo.language.yaml.queries import read_formula
from kabo.language.yaml.syntax import expression_of, parse
from kabo.language.yaml.values import Reader

DOMAIN_KEYS = (
    "domain", "types", "constants", "predicates", "functions", "procedures", "update_rules", "actions", "events",
)  # fmt: skip
ACTION_KEYS = ("parameters", "preconditions", "geometry", "effects", "sense", "cost")
EVENT_KEYS = ("parameters", "preconditions", "effects")
FUNCTION_KEYS = ("arguments", "value")

_Read = TypeVar("_Read")


@dataclass
class DomainReading:
    """A domain that is being read, and its vocabulary, to which problems add their names."""

    findings: Findings
    reader: Reader
    vocabulary: Vocabulary
    tasks: ProcedureSignatures  # of geometry
    constants: dict[str, str] = field(default_factory=dict)
    predicates: dict[str, tuple[str, ...]] = field(default_factory=dict)
    functions: dict[str, Function] = field(default_factory=dict)
    procedures: dict[str, Procedure] = field(default_factory=dict)
    domain: Domain | None = None


def read_domain(root: Mapping, findings: Findings, *, within: Path | None = None) -> DomainReading:
    """The domain that a document describes; formulas that cannot be read are reported and left out.

    `within`: if given, no task file outside of this folder is opened.
    """
    procedures = ProcedureSignatures(os.path.dirname(root.source.name), findings, within)
    reading = DomainReading(findings, Reader(findings), Vocabulary(findings, procedures=procedures), procedures)
    reader = reading.reader
    reader.keys(root, DOMAIN_KEYS, "a domain")
    name = reader.name(reader.require(root, "domain", "a domain"), "a domain")
    _read_types(reading, reader.require(root, "types", "a domain"), None)
    _read_constants(reading, root.get("constants"))
    _read_predicates(reading, root.get("predicates"))
    _read_functions(reading, root.get("functions"))
    _read_procedures(reading, root.get("procedures"))
    rules = _read_rules(reading, root.get("update_rules"))
    actions = _read_actions(reading, reader.require(root, "actions", "a domain"))
    events = _read_actions(reading, root.get("events"), "an event", EVENT_KEYS)
    for name_of, event in events.items():
        if name_of in actions and event.place is not None:
            findings.add(event.place, f'"{name_of}" is an action, too', "an event happens, and nobody does it")
    reading.domain = Domain(
        name or "", dict(reading.vocabulary.types.parents), reading.constants, reading.predicates, reading.functions,
        rules, actions, root.source.path, reading.procedures, events=events,
    )  # fmt: skip
    return reading


# -------------------------------------------------------------------------------------------------- declarations
def _is_null(node: YamlNode) -> bool:
    """Whether a tool for YAML wrote `null` where nothing follows: a type without subtypes."""
    return isinstance(node, Scalar) and not node.style and node.text in {"null", "~"}


def _read_types(reading: DomainReading, node: YamlNode | None, parent: str | None) -> None:
    if isinstance(node, Mapping):
        for _, key, value in reading.reader.entries(node, "types"):
            name = _declare_type(reading, key, parent)
            if not _is_null(value):
                _read_types(reading, value, name or parent)
    else:
        for item in reading.reader.items(node, "types"):
            if isinstance(item, Scalar):
                _declare_type(reading, item, parent)
            else:
                reading.findings.add(
                    item.place, "a type must be a name; subtypes stand under their type as a mapping"
                )


def _declare_type(reading: DomainReading, scalar: Scalar, parent: str | None) -> str | None:
    name, types = scalar.text, reading.vocabulary.types
    if not reading.reader.check_name(scalar, "a type"):
        return None
    if name == NUMBER:
        reading.findings.add(scalar.place, '"number" is built in and cannot be the name of a type')
        return None
    earlier = types.places.get(name)
    if earlier is not None:
        reading.findings.add(scalar.place, f'the type "{name}" is declared twice', f"first in line {earlier.line}")
        return None
    types.add(name, scalar.place, parent)
    return name


def named(scalar: Scalar, role: Literal["constant", "object"], kind: str | None) -> Symbol:
    """The symbol of an object or constant; if `kind` is None, its type is unknown."""
    return Symbol(role, scalar.text, scalar.place, ANY if kind is None else (kind,), type=kind or "")


def read_named_things(
    reader: Reader, vocabulary: Vocabulary, node: YamlNode | None, what: str
) -> Iterator[tuple[Scalar, str | None]]:
    """Every name in a mapping `{type: [names]}` with its type; the type is None if it is not declared."""
    for kind, key, value in reader.entries(node, f"the {what}s"):
        known = vocabulary.check_type(kind, key.place, f"of {what}s")
        for item in reader.items(value, f"the {what}s of a type"):
            if reader.name(item, f"{'an' if what[0] in 'aeiou' else 'a'} {what}") and isinstance(item, Scalar):
                yield item, kind if known else None


def _read_constants(reading: DomainReading, node: YamlNode | None) -> None:
    for scalar, kind in read_named_things(reading.reader, reading.vocabulary, node, "constant"):
        if reading.vocabulary.declare(named(scalar, "constant", kind)) and kind is not None:
            reading.constants[scalar.text] = kind


def _read_predicates(reading: DomainReading, node: YamlNode | None) -> None:
    for name, key, value in reading.reader.entries(node, "the predicates"):
        kinds = _argument_types(reading, value, f'of the predicate "{name}"')
        if reading.reader.check_name(key, "a predicate") and reading.vocabulary.declare(
            Symbol("predicate", name, key.place, ANY, kinds)
        ):
            reading.predicates[name] = _names(kinds)


def _argument_types(
    reading: DomainReading, node: YamlNode | None, where: str, *, numbers: bool = False
) -> tuple[Kind, ...]:
    kinds: list[Kind] = []
    for item in reading.reader.items(node, f"the arguments {where}"):
        scalar = reading.reader.scalar(item, f"a type {where}")
        known = scalar is not None and (
            (numbers and scalar.text == NUMBER)
            or reading.vocabulary.check_type(scalar.text, scalar.place, where, *([NUMBER] if numbers else []))
        )
        kinds.append((scalar.text,) if known and scalar is not None else ANY)
    return tuple(kinds)


def _names(kinds: tuple[Kind, ...]) -> tuple[str, ...]:
    """The types of arguments; those that are unknown are left out."""
    return tuple(type_of(kind) for kind in kinds if kind != ANY)


def _range(kind: Kind) -> tuple[str | None, tuple[str, ...] | None]:
    """The type of a function's values if they are objects, and the values if they are listed."""
    if isinstance(kind, Values):
        return None, kind.names
    return (None if kind in (ANY, NUMBERS, TEST) else type_of(kind)), None


def _read_functions(reading: DomainReading, node: YamlNode | None) -> None:
    for name, key, value in reading.reader.entries(node, "the functions"):
        mapping = reading.reader.mapping(value, f'the function "{name}"')
        if mapping is None:
            if isinstance(value, Scalar) and value.empty:
                reading.findings.add(key.place, f'the function "{name}" needs the key "value"')
            continue
        what = f'the function "{name}"'
        reading.reader.keys(mapping, FUNCTION_KEYS, what)
        kinds = _argument_types(reading, mapping.get("arguments"), f"of {what}")
        kind = _value_kind(reading, reading.reader.require(mapping, "value", what, key), what)
        if reading.reader.check_name(key, "a function") and reading.vocabulary.declare(
            Symbol("function", name, key.place, kind, kinds)
        ):
            reading.functions[name] = Function(name, _names(kinds), *_range(kind))


def _read_procedures(reading: DomainReading, node: YamlNode | None) -> None:
    """External procedures: as functions, but a value is not needed, and arguments may be numbers."""
    for name, key, value in reading.reader.entries(node, "the procedures"):
        what = f'the procedure "{name}"'
        mapping = reading.reader.mapping(value, what)
        kinds: tuple[Kind, ...] = ()
        kind: Kind = TEST
        if mapping is not None:
            reading.reader.keys(mapping, FUNCTION_KEYS, what)
            kinds = _argument_types(reading, mapping.get("arguments"), f"of {what}", numbers=True)
            if (answer := mapping.get("value")) is not None:
                kind = _value_kind(reading, answer, what)
        if name in reading.vocabulary.procedures:
            reading.findings.add(key.place, f'"{name}" is the name of a procedure of geometry')
        elif reading.reader.check_name(key, "a procedure") and reading.vocabulary.declare(
            Symbol("procedure", name, key.place, kind, kinds)
        ):
            reading.procedures[name] = Procedure(name, _names(kinds), kind == TEST, *_range(kind), key.place)


def _value_kind(reading: DomainReading, node: YamlNode | None, what: str) -> Kind:
    if isinstance(node, Sequence):
        return _enumeration(reading, node, what)
    scalar = reading.reader.scalar(node, f"the value of {what}")
    if scalar is None or scalar.text == NUMBER:
        return ANY if scalar is None else NUMBERS
    where = f"as the value of {what}"
    return (scalar.text,) if reading.vocabulary.check_type(scalar.text, scalar.place, where, NUMBER) else ANY


def _enumeration(reading: DomainReading, node: Sequence, what: str) -> Kind:
    names: dict[str, None] = {}
    for item in node.items:
        name = reading.reader.name(item, "a value")
        if name is None:
            continue
        if name in names:
            reading.findings.add(item.place, f'the value "{name}" stands twice in the list of {what}')
        names[name] = None
        earlier = reading.vocabulary.symbols.get(name)
        if earlier is None or earlier.role != "value":  # equal names in two lists are the same value
            reading.vocabulary.declare(Symbol("value", name, item.place, Values((name,))))
    if not names:
        reading.findings.add(node.place, f"{what} needs at least one value")
        return ANY
    return Values(tuple(names))


# ------------------------------------------------------------------------------------------------------ formulas
def read_parsed(
    scalar: Scalar,
    start: str,
    vocabulary: Vocabulary,
    where: str,
    read: Callable[[NameResolver, Expression], _Read],
    scope: MappingType[str, Symbol] | None = None,
) -> _Read | None:
    """The result of `read` for the formula in `scalar`, with the variables in `scope`; None if it does not parse."""
    parsed = parse(scalar, start, vocabulary.findings)
    if parsed is None:
        return None
    here = NameResolver(scalar.source, scalar.source.text, vocabulary, where, YAML, scope or {})
    return read(here, expression_of(parsed, parsed.tree))


def _read_rules(reading: DomainReading, node: YamlNode | None) -> tuple[f.Effect, ...]:
    def read(here: NameResolver, node: Expression) -> tuple[f.Effect, ...]:
        return read_effects(here, node, world=False)

    scalars = reading.reader.formulas(node, "an update rule")
    rules = [read_parsed(scalar, "effect", reading.vocabulary, "in an update rule", read) for scalar in scalars]
    return tuple(effect for group in rules for effect in group or ())


def _read_actions(
    reading: DomainReading, node: YamlNode | None, what: str = "an action", keys: tuple[str, ...] = ACTION_KEYS
) -> dict[str, Action]:
    actions: dict[str, Action] = {}
    kind = what.rpartition(" ")[2]
    for name, key, value in reading.reader.entries(node, f"the {kind}s"):
        reading.reader.check_name(key, what)
        if isinstance(value, Scalar) and value.empty:
            value = Mapping(value.source, key.start, key.end)
        mapping = reading.reader.mapping(value, f'the {kind} "{name}"')
        if mapping is not None:
            reading.reader.keys(mapping, keys, f'the {kind} "{name}"')
            actions[name] = _read_action(reading, name, key, mapping)
    return actions


def _read_action(reading: DomainReading, name: str, key: Scalar, mapping: Mapping) -> Action:
    reader, place = reading.reader, key.place
    parameters, scope = _read_parameters(reading, name, mapping.get("parameters"))
    of_action = f'of action "{name}"'

    def read_as(
        scalar: Scalar, start: str, where: str, read: Callable[[NameResolver, Expression], _Read]
    ) -> _Read | None:
        return read_parsed(scalar, start, reading.vocabulary, where, read, scope)

    where = f"in a precondition {of_action}"
    scalars = reader.formulas(mapping.get("preconditions"), f"a precondition {of_action}")
    formulas = [read_as(scalar, "formula", where, read_formula) for scalar in scalars]
    geometry = None
    if (scalar := reader.scalar(mapping.get("geometry"), f"`geometry` {of_action}")) is not None:
        geometry = read_as(scalar, "procedure", f"in `geometry` {of_action}", read_call)
    where = f"in an effect {of_action}"
    scalars = reader.formulas(mapping.get("effects"), f"an effect {of_action}")
    effects = [read_as(scalar, "effect", where, read_effects) for scalar in scalars]
    where = f"in `sense` {of_action}"
    scalars = reader.formulas(mapping.get("sense"), f"`sense` {of_action}")
    sense = [read_as(scalar, "value", where, _read_sensed) for scalar in scalars]
    cost: f.Term | None = f.Number(1.0)
    if (scalar := reader.scalar(mapping.get("cost"), f"the cost {of_action}")) is not None:
        cost = read_as(scalar, "value", f"in the cost {of_action}", _read_cost)
    return Action(
        name, parameters, tuple(each for each in formulas if each is not None), geometry,
        tuple(effect for group in effects for effect in group or ()),
        tuple(each for each in sense if each is not None), cost or f.Number(1.0), place,
    )  # fmt: skip


def _read_parameters(
    reading: DomainReading, action: str, node: YamlNode | None
) -> tuple[tuple[Parameter, ...], dict[str, Symbol]]:
    bound: dict[str, Symbol] = {}
    parameters: list[Parameter] = []
    where = f'in the parameters of action "{action}"'
    for name, key, value in reading.reader.entries(node, f'the parameters of action "{action}"'):
        correct = reading.reader.check_name(key, "a parameter")
        kind: Kind = ANY
        value_of = None
        if isinstance(value, Mapping):
            kind, value_of = _read_run_time_variable(reading, value, bound, where)
            symbol = Symbol("run-time variable", name, key.place, kind, (), value_of, type=type_of(kind))
        else:
            scalar = reading.reader.scalar(value, f'the type of the parameter "{name}"')
            if scalar is not None and reading.vocabulary.check_type(scalar.text, scalar.place, where):
                kind = (scalar.text,)
            symbol = Symbol("parameter", name, key.place, kind, type=type_of(kind))
        earlier = bound.get(name) or reading.vocabulary.symbols.get(name)
        if earlier is not None:
            reading.vocabulary.report_taken(symbol, earlier)
        bound[name] = symbol
        if correct:
            parameters.append(Parameter(name, symbol.type, value_of, key.place))
    return tuple(parameters), bound


def _read_run_time_variable(
    reading: DomainReading, mapping: Mapping, scope: dict[str, Symbol], where: str
) -> tuple[Kind, f.Application | None]:
    what = "a run-time variable"
    reading.reader.keys(mapping, ("value_of",), what)
    scalar = reading.reader.scalar(reading.reader.require(mapping, "value_of", what), "`value_of`")
    if scalar is None:
        return ANY, None
    term = read_parsed(scalar, "value", reading.vocabulary, where, NameResolver.application, scope)
    symbol = None if term is None else scope.get(term.function) or reading.vocabulary.symbols.get(term.function)
    return (ANY if symbol is None else symbol.kind), term


def _read_sensed(here: NameResolver, node: Expression) -> f.Atom | f.Application | None:
    symbol = here.find(node.text) if node.kind in ("name", "call") else None
    if symbol is None and node.kind in ("name", "call"):
        report_unknown(here, node, "predicate or function", "predicate", "function")
        return None
    return here.application(node) if symbol is not None and symbol.role == "function" else here.atom(node)


def _read_cost(here: NameResolver, node: Expression) -> f.Term | None:
    found = here.term(node)
    if found is not None and found[1] not in (NUMBERS, ANY):
        here.report(node, "a cost must be a number")
        return None
    return None if found is None else found[0]
