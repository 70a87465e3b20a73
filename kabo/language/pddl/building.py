"""Builds problems about the world, as PDDL describes them, from parts that a program hands over instead of files.

Names, types and the translation of conditions, effects and what is unknown are those of PDDL files
[docs/reference/languages.md#pddl]; nothing is written or parsed. `kabo.up` builds its problems so.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from kabo.errors import InputError
from kabo.language import formulas as f
from kabo.language.connectives import denied
from kabo.language.findings import Findings
from kabo.language.names import Names
from kabo.language.pddl.actions import PddlAction, Surmise, build_action
from kabo.language.pddl.dialect import PDDL
from kabo.language.pddl.effects import ConditionalEffect
from kabo.language.pddl.initial import Initial, build_initial
from kabo.language.pddl.problem import may_be_unknown
from kabo.language.problem import Action, Domain, Problem
from kabo.language.resolver import NameResolver
from kabo.language.source import SourceFile
from kabo.language.tree_algebra import nodes
from kabo.language.types import NUMBERS, OBJECT
from kabo.language.vocabulary import Symbol, Vocabulary

_ROOT = "(any object)"  # no file can declare a type of this name


@dataclass
class WorldAction:
    """An action that changes the world: its conditions hold there, and what it senses is looked at there.

    `name` is the caller's; `sensed` are atoms and terms. Without a `cost` the action costs 1.
    """

    name: str
    parameters: tuple[f.Variable, ...] = ()
    preconditions: list[f.Formula] = field(default_factory=list)
    effects: list[ConditionalEffect] = field(default_factory=list)
    sensed: list[f.Atom | f.Application] = field(default_factory=list)
    cost: f.Term | None = None


class ProblemBuilder:
    """Collects declarations, actions and what is known at the start, and builds a problem of them.

    Everything has the caller's name, of any spelling; what is declared gets a name in kabo, which is returned.
    An atom that `start` does not mention is known to be false at the start.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.start = Initial()
        self._findings = Findings()
        self._vocabulary = Vocabulary(self._findings)
        self._place = f.Place(name, 1, 1)
        self._source = SourceFile(Path(name), name, "")
        root = self._vocabulary.types.names.take(OBJECT)
        self._vocabulary.types.add(root, None, None, _ROOT)
        self._vocabulary.types.root = root
        self._action_names = Names()
        self._actions: list[tuple[PddlAction, f.Term | None]] = []
        self._unknown_functions: set[str] = set()

    # ------------------------------------------------------------------------------------------------- declarations
    def type(self, original: str, parent: str | None = None) -> str:
        """Declares a type below `parent`, a type in kabo; without one, below the type of all objects."""
        types = self._vocabulary.types
        name = types.names.take(original)
        types.add(name, self._place, parent or types.root, original)
        return name

    def object(self, original: str, kind: str) -> f.Constant:
        """Declares an object of a type."""
        vocabulary = self._vocabulary
        name = vocabulary.names.take(original)
        vocabulary.objects[original] = Symbol("object", name, self._place, (kind,), original=original, type=kind)
        return f.Constant(name)

    def predicate(self, original: str, arguments: Sequence[str]) -> str:
        """Declares a predicate by the types of its arguments."""
        return self._declare(Symbol("predicate", "", self._place, (), _kinds(arguments), original=original))

    def function(self, original: str, arguments: Sequence[str], value: str | None) -> str:
        """Declares a function; its values are objects of the type `value`, or numbers."""
        kind = NUMBERS if value is None else (value,)
        return self._declare(Symbol("function", "", self._place, kind, _kinds(arguments), original=original))

    def variable(self, original: str, kind: str, around: Iterable[f.Variable] = ()) -> f.Variable:
        """A parameter or a quantified variable, whose name differs from those of variables `around` it."""
        return f.Variable(self._vocabulary.names.free(original, [each.name for each in around]), kind)

    def action(self, action: WorldAction) -> str:
        """Adds an action; returns its name in kabo."""
        name = self._action_names.take(action.name)
        where = f'in action "{action.name}"'
        schema = PddlAction(
            name, NameResolver(self._source, "", self._vocabulary, where, PDDL), action.parameters,
            list(action.preconditions), list(action.effects), list(action.sensed), self._place,
        )  # fmt: skip
        self._actions.append((schema, action.cost))
        return name

    def _declare(self, symbol: Symbol) -> str:
        name = self._vocabulary.names.take(symbol.written)
        self._vocabulary.symbols[symbol.written] = replace(symbol, name=name)
        return name

    # ----------------------------------------------------------------------------------------------- initial knowledge
    def unknown(self, literal: f.Literal) -> None:
        """It is not known at the start whether the literal's atom holds."""
        self.start.unknown.setdefault(literal.atom, literal)

    def exactly_one(self, claims: Iterable[f.Claim]) -> None:
        """It is known at the start that exactly one of the claims holds: of literals, and of `f = v`."""
        self._constraint("Kx", self.start.exactly_one, tuple(dict.fromkeys(claims)))

    def at_least_one(self, claims: Iterable[f.Claim]) -> None:
        """It is known at the start that one of the claims holds, or more."""
        members = tuple(dict.fromkeys(claims))
        if any(denied(each) in members for each in members):
            self._not_known(members)  # the constraint is always true
        else:
            self._constraint("Kor", self.start.at_least_one, members)

    def _constraint(self, database: f.Database, changes: list[f.Change], members: tuple[f.Claim, ...]) -> None:
        if len(members) > 1:
            self._not_known(members)
            changes.append(f.Change("add", database, members, self._place))
        elif isinstance(members[0], f.Literal):
            self.start.facts[members[0].atom] = members[0]
        elif isinstance(members[0].left, f.Application):
            self.start.values[members[0].left] = members[0]

    def _not_known(self, claims: Iterable[f.Claim]) -> None:
        for each in claims:
            if isinstance(each, f.Literal):
                self.unknown(each)
            elif isinstance(each.left, f.Application):
                self._unknown_functions.add(each.left.function)

    # ----------------------------------------------------------------------------------------------------- building
    def refuse(self, message: str, hint: str | None = None) -> None:
        """Records that something cannot be said in kabo; `problem` then raises an error with everything recorded."""
        self._findings.add(self._place, message, hint)

    def problem(self, goal: Sequence[f.Formula]) -> Problem:
        """The problem of all that was declared.

        Raises:
            InputError: something cannot be said in kabo; names everything of this kind.
        """
        for atom in [atom for atom in self.start.unknown if atom in self.start.facts]:
            del self.start.unknown[atom]  # a constraint of one member tells it
        schemas = [schema for schema, _ in self._actions]
        unknown = may_be_unknown(schemas, self.start.unknown_symbols() | self._unknown_functions)
        surmise = Surmise(self._vocabulary, unknown)
        actions: dict[str, Action] = {}
        for schema, cost in self._actions:
            built = build_action(schema, surmise)
            actions[schema.name] = built if cost is None else replace(built, cost=cost)
        if self._findings.errors:
            raise InputError(each for each in self._findings.diagnostics if each.severity == "error")
        objects = self._vocabulary.types_of_objects()
        mentioned = {node.name for node in nodes(tuple(actions.values())) if isinstance(node, f.Constant)}
        constants = {name: kind for name, kind in objects.items() if name in mentioned}
        name = Names().take(self.name)
        domain = Domain(
            name, self._vocabulary.types.in_order(), constants, self._vocabulary.predicates_of_domain(),
            self._vocabulary.functions_of_domain(), (), actions, worldly=True,
        )  # fmt: skip
        start = build_initial(self._vocabulary, self.start, None)
        return Problem(name, domain, constants | objects, start, tuple(goal), {}, None, Path(name), {})


def _kinds(arguments: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    return tuple((each,) for each in arguments)
