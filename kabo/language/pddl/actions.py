"""Translates PDDL actions into kabo's: parameters, preconditions, effects, sensed facts, cost.

This takes two steps, because an effect changes knowledge or the world depending on which facts *any* action may
make unknown: `read_action` reads every action, then `build_action` decides and translates.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from kabo.language import formulas as f
from kabo.language.connectives import conjunction, disjunction
from kabo.language.pddl.conditions import read_condition
from kabo.language.pddl.conflicts import ConflictContext, additions_win, may_be_same
from kabo.language.pddl.declarations import read_variables
from kabo.language.pddl.dialect import read_atom, resolver_of
from kabo.language.pddl.effects import ConditionalEffect, read_effects
from kabo.language.pddl.forms import Document, Form, Node, Token
from kabo.language.pddl.updates import updates_of
from kabo.language.problem import Action, Parameter
from kabo.language.resolver import NameResolver
from kabo.language.tree_algebra import symbols
from kabo.language.types import types_of
from kabo.language.vocabulary import Symbol, Vocabulary

_PARTS = (":parameters", ":precondition", ":effect", ":observe")
_MOST_COMPARED = 100
_MOST_CHANGES = 30
_REFUSED_PARTS = (":duration", ":condition", ":vars", ":only-in-expansions", ":expansion", ":probability", ":cost")


@dataclass
class PddlAction:
    """An action of a PDDL file that has been read, but not yet translated to kabo's form."""

    name: str  # kabo's
    resolver: NameResolver
    parameters: Sequence[Symbol | f.Variable] = ()
    preconditions: list[f.Formula] = field(default_factory=list)
    pieces: list[ConditionalEffect] = field(default_factory=list)
    sensed: list[f.Atom | f.Application] = field(default_factory=list)
    place: f.Place | None = None


def read_action(document: Document, vocabulary: Vocabulary, form: Form, name: str) -> PddlAction:
    """Reads the parts of `(:action name …)`; faulty parts are reported and left out."""
    parts = _parts_of(document, form)
    shown = form.items[1].text if isinstance(form.items[1], Token) else name
    where = f'in action "{shown}"'
    schema = PddlAction(name, resolver_of(document, vocabulary, where), place=document.place(form.items[1]))
    parameters = parts.get(":parameters")
    if isinstance(parameters, Form):
        bound = read_variables(schema.resolver, parameters.items, split=False)[0]
        schema.parameters = list(bound.values())
        schema.resolver = schema.resolver.inside(bound)
        for each in bound.values():
            schema.preconditions += _membership(each)
    elif parameters is not None:
        document.report(parameters, f'expected "(?x - type …)" as the parameters of action "{shown}"')
    if ":precondition" in parts:
        condition = read_condition(schema.resolver, parts[":precondition"])
        if condition is not None:
            flat = conjunction([condition])
            schema.preconditions += flat.parts if isinstance(flat, f.And) else [flat]
            schema.preconditions = [each for each in schema.preconditions if each != f.Truth(True)]
    if ":effect" in parts:
        schema.pieces = read_effects(schema.resolver, parts[":effect"])
    if ":observe" in parts:
        schema.sensed = list(_sensed(schema.resolver, parts[":observe"]))
    return schema


def _parts_of(document: Document, form: Form) -> dict[str, Node]:
    """The values behind `:parameters`, `:precondition`, `:effect` and `:observe`."""
    found: dict[str, Node] = {}
    waiting = form.items[2:][::-1]
    while waiting:
        key = waiting.pop()
        word = key.text if isinstance(key, Token) else ""
        if word not in _PARTS:
            if word in _REFUSED_PARTS:
                document.report(key, f'"{word}" of an action is not supported')
            else:
                hint = document.findings.near(word, _PARTS) if word else f"an action has {', '.join(_PARTS)}"
                document.report(key, f'unexpected "{document.text(key)}" in an action', hint)
            if not word.startswith(":"):
                continue
        elif word in found:
            document.report(key, f'"{word}" stands twice in this action')
        if not waiting or (isinstance(waiting[-1], Token) and waiting[-1].text.startswith(":")):
            document.report(key, f'"{word}" has no value')
            continue
        value = waiting.pop()
        if word in _PARTS:
            found.setdefault(word, value)
    return found


def _membership(bound: Symbol) -> Iterator[f.Formula]:
    """That a parameter of the type (either a b) is one of these: kabo declares it with their common supertype."""
    variable, kinds = bound.variable, types_of(bound.kind)
    if len(kinds) == 1 or variable.type in kinds:
        return
    one_of = []
    for kind in kinds:
        same = f.Variable(f"{variable.name}_as_{kind}", kind, variable.place)
        equal = f.Know(f.Comparison("=", variable, same, variable.place), variable.place)
        one_of.append(f.Exists((same,), equal, variable.place))
    yield disjunction(one_of, variable.place)


def _sensed(here: NameResolver, node: Node) -> Iterator[f.Atom]:
    """The atoms of `:observe`: one, its negation, or several joined by `and`."""
    head = node.head if isinstance(node, Form) else ""
    if isinstance(node, Form) and not here.vocabulary.is_predicate(head):
        if head == "and" or not node.items:
            for part in node.rest:
                yield from _sensed(here, part)
            return
        if head == "not" and len(node.items) == 2:
            yield from _sensed(here, node.items[1])
            return
        if head in ("or", "oneof", "forall", "exists", "imply", "when", "="):
            here.report(node, f'"{head}" in :observe is not supported {here.where}', "observe single atoms")
            return
    atom = read_atom(here, node)
    if atom is not None:
        yield atom


# -------------------------------------------------------------------------------------------------------- building
@dataclass(frozen=True)
class Surmise:
    """Facts about the whole problem on which the translation of an action depends.

    Attributes:
        vocabulary: all declared names.
        unknown: the predicates and functions that may be unknown for some arguments at some time.
        cost: the function (by kabo's name) whose sum is to be minimised, if any.
        cost_only: whether the function `cost` is used for nothing else.
    """

    vocabulary: Vocabulary
    unknown: frozenset[str]
    cost: str | None = None
    cost_only: bool = False

    def known(self, tree: object) -> bool:
        """Whether all predicates and functions in a formula tree are always known."""
        return not self.unknown & symbols(tree)


def build_action(schema: PddlAction, surmise: Surmise) -> Action:
    """The action in kabo's form; constructs that kabo cannot express are reported."""
    here, vocabulary = schema.resolver, surmise.vocabulary
    sorts: Mapping[str, str] = vocabulary.types_of_objects()

    def report(piece: ConditionalEffect, fatal: bool) -> None:
        message = "this effect may meet one that adds the same atom, and nobody knows whether it does"
        if fatal:
            _report(here, piece, f"{message}: not supported {here.where}")
        else:
            _report(here, piece, f"{message}; both are taken as they stand", warning=True)

    cost = [each for each in schema.pieces if each.symbol == surmise.cost]
    pieces = [each for each in schema.pieces if not (surmise.cost_only and each.symbol == surmise.cost)]
    around = ConflictContext(vocabulary.types, sorts, tuple(schema.preconditions), surmise.known, report)
    pieces = summed(here, pieces)
    _warn_of_meeting_numbers(here, pieces, around)
    effects = updates_of(here, additions_win(pieces, around), surmise.known)
    for atom in schema.sensed:
        sensed = atom.predicate if isinstance(atom, f.Atom) else atom.function
        if any(each.symbol == sensed for each in pieces):
            _report(here, atom, f"sensing what the same action changes is not supported {here.where}")
    parameters = tuple(Parameter(each.name, each.type, None, each.place) for each in schema.parameters)
    return Action(
        schema.name, parameters, tuple(schema.preconditions), None, effects, tuple(schema.sensed),
        _cost(here, cost, surmise), schema.place,
    )  # fmt: skip


def summed(here: NameResolver, pieces: list[ConditionalEffect]) -> list[ConditionalEffect]:
    """The effects, in which several increases and decreases of one number are joined into their sum."""
    found: list[ConditionalEffect] = []
    joined: dict[int, int] = {}  # how many changes are one now, by where it is
    numbers: dict[object, int] = {}  # term and condition -> where its first change is
    for piece in pieces:
        key = (piece.outcome.left, piece.condition) if isinstance(piece.outcome, f.Comparison) else None
        rival = None if key is None else numbers.setdefault(key, len(found))
        if rival is None or rival == len(found):
            found.append(piece)
            continue
        first = found[rival]
        joined[rival] = joined.get(rival, 1) + 1
        simple = all(not each.variables and each.condition == f.Truth(True) for each in (first, piece))
        if joined[rival] > _MOST_CHANGES:
            _report(here, piece, f'"{piece.symbol}" is changed more than {_MOST_CHANGES} times {here.where}')
            break
        if simple and first.changes and piece.changes and _is_sum(first) and _is_sum(piece):
            found[rival] = _joined(first, piece)
        else:
            message = f'"{piece.symbol}" is changed twice by this action: not supported {here.where}'
            _report(here, piece, message)
    return found


def _warn_of_meeting_numbers(here: NameResolver, pieces: list[ConditionalEffect], around: ConflictContext) -> None:
    """Warns of changes of one function's values that may turn out to be of the same value."""
    changed: dict[str, list[ConditionalEffect]] = {}
    for piece in pieces:
        if isinstance(piece.outcome, f.Comparison):
            rivals = changed.setdefault(piece.symbol, [])
            if len(rivals) < _MOST_COMPARED and any(may_be_same(piece, each, around) for each in rivals):
                message = "two effects may change the same value: then the action is not applicable here"
                _report(here, piece, message, warning=True)
            rivals.append(piece)


def _is_sum(piece: ConditionalEffect) -> bool:
    right = piece.outcome.right if isinstance(piece.outcome, f.Comparison) else None
    return isinstance(right, f.Arithmetic) and right.operator in "+-"


def _joined(first: ConditionalEffect, second: ConditionalEffect) -> ConditionalEffect:
    assert isinstance(first.outcome, f.Comparison) and isinstance(second.outcome, f.Comparison)
    change = second.outcome.right
    assert isinstance(change, f.Arithmetic)
    right = f.Arithmetic(change.operator, first.outcome.right, change.right, change.place)
    outcome = f.Comparison("=", first.outcome.left, right, first.outcome.place)
    return ConditionalEffect((), f.Truth(True), outcome, True, first.place)


def _cost(here: NameResolver, pieces: Iterable[ConditionalEffect], surmise: Surmise) -> f.Term:
    """What the action adds to the cost; 1 if no cost is minimised."""
    if surmise.cost is None:
        return f.Number(1.0)
    total: f.Term = f.Number(0.0)
    for piece in pieces:
        right = piece.outcome.right if isinstance(piece.outcome, f.Comparison) else None
        plain = not piece.variables and piece.condition == f.Truth(True)
        if not (plain and piece.changes and isinstance(right, f.Arithmetic) and right.operator == "+"):
            _report(here, piece, f"a cost that is not simply increased is not supported {here.where}")
            continue
        if surmise.cost in symbols(right.right):
            _report(here, piece, f"a cost that depends on itself is not supported {here.where}")
        total = right.right if total == f.Number(0.0) else f.Arithmetic("+", total, right.right, right.place)
    return total


def _report(
    here: NameResolver, tree: ConditionalEffect | f.Atom | f.Application, message: str, *, warning: bool = False
) -> None:
    place = tree.place or f.Place(here.source.name, 1, 1)
    here.findings.add(place, message, None, warning=warning)
