"""The names that formulas may use: types, and one namespace for everything else [docs/files.md#rules].

A name that could not be declared properly is kept with what is known of it, so that one mistake gives one finding.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from kabo.language.findings import Findings, spell_place
from kabo.language.formulas import Application, Constant, Place, Variable
from kabo.language.task_description import Signature

NUMBER = "number"
TEST = "true or false"  # what an external procedure without a value answers; no name of a type has blanks


@dataclass(frozen=True)
class Values:
    """The range of a function that lists its values."""

    names: tuple[str, ...]

    def __str__(self) -> str:
        return "{" + ", ".join(self.names) + "}"


Kind = str | Values | None  # a type's name, `number`, an enumeration; None: unknown, already reported


@dataclass(frozen=True)
class Symbol:
    """What a name stands for; `kind` is that of its value, `arguments` of a predicate, function or procedure."""

    role: Literal[
        "predicate",
        "function",
        "procedure",
        "constant",
        "object",
        "value",
        "parameter",
        "run-time variable",
        "variable",
    ]
    name: str
    place: Place
    kind: Kind = None
    arguments: tuple[Kind, ...] = ()
    value_of: Application | None = None

    @property
    def signature(self) -> str:
        """How it was declared: `robot_grasps(robot, bottle)`."""
        if self.arguments:
            return f"{self.name}({', '.join(str(kind or '?') for kind in self.arguments)})"
        return self.name

    @property
    def description(self) -> str:
        """The role with its article: `an object`, `a predicate`."""
        return ("an " if self.role == "object" else "a ") + self.role


@dataclass
class Vocabulary:
    """Types and symbols of a domain, and of a problem on top of it."""

    findings: Findings
    types: dict[str, str | None] = field(default_factory=dict)
    type_places: dict[str, Place] = field(default_factory=dict)
    symbols: dict[str, Symbol] = field(default_factory=dict)
    procedures: Mapping[str, Signature | None] = field(default_factory=dict)  # of geometry; None: a broken file

    def is_a(self, kind: str, ancestor: str) -> bool:
        """Whether type `kind` is `ancestor` or one of its subtypes."""
        current: str | None = kind
        while current is not None:
            if current == ancestor:
                return True
            current = self.types.get(current)
        return False

    def fits(self, kind: Kind, wanted: Kind) -> bool:
        """Whether a term of `kind` may stand where `wanted` is asked for."""
        if kind is None or wanted is None or kind == wanted:
            return True
        if isinstance(kind, Values) or isinstance(wanted, Values):
            return isinstance(kind, Values) and isinstance(wanted, Values) and set(kind.names) <= set(wanted.names)
        return NUMBER not in (kind, wanted) and self.is_a(kind, wanted)

    def comparable(self, first: Kind, second: Kind) -> bool:
        """Whether terms of these kinds can be equal."""
        if isinstance(first, Values) and isinstance(second, Values):
            return bool(set(first.names) & set(second.names))
        return self.fits(first, second) or self.fits(second, first)

    def declare(self, symbol: Symbol) -> bool:
        """Adds a symbol to the namespace; reports it if the name is taken, which also forbids shadowing."""
        earlier = self.symbols.get(symbol.name)
        if earlier is None:
            self.symbols[symbol.name] = symbol
            return True
        self.report_taken(symbol, earlier)
        return False

    def report_taken(self, symbol: Symbol, earlier: Symbol) -> None:
        """Reports that the name of `symbol` already means `earlier`."""
        message = f'"{symbol.name}" is already the name of {earlier.description}'
        hint = f"declared at {spell_place(earlier.place)}; predicates, functions, objects, variables share names"
        self.findings.add(symbol.place, message, hint)

    def check_type(self, name: str, place: Place, where: str, *also: str) -> bool:
        """Whether `name` is a type; reports it if not, and may propose one of `also` as well."""
        if name in self.types:
            return True
        declared = {
            known: (known, self.type_places.get(known)) for known in self.types if self.findings.may_suggest
        }
        if name in self.symbols:
            hint: str | None = f'"{name}" is {self.symbols[name].description}'
        else:
            hint = self.findings.near(name, [*declared, *also], declared)
        self.findings.add(place, f'unknown type "{name}" {where}', hint)
        return False


@dataclass(frozen=True)
class Scope:
    """The names visible inside an action or a quantifier: the vocabulary's and those bound around it."""

    vocabulary: Vocabulary
    bound: Mapping[str, Symbol] = field(default_factory=dict)

    def find(self, name: str) -> Symbol | None:
        """What `name` means here."""
        return self.bound.get(name) or self.vocabulary.symbols.get(name)

    def names(self, *roles: str) -> dict[str, tuple[str, Place | None]]:
        """Signature and place of every visible symbol with one of the roles (of all, without any)."""
        visible = {**self.vocabulary.symbols, **self.bound}
        return {name: (s.signature, s.place) for name, s in visible.items() if not roles or s.role in roles}

    def check_free(self, symbol: Symbol) -> None:
        """Reports it if the name of `symbol` is taken here."""
        earlier = self.find(symbol.name)
        if earlier is not None:
            self.vocabulary.report_taken(symbol, earlier)

    def with_bound(self, symbols: Mapping[str, Symbol]) -> "Scope":
        """This scope with more names bound; names that are taken are reported and keep their new meaning."""
        for symbol in symbols.values():
            self.check_free(symbol)
        return Scope(self.vocabulary, {**self.bound, **symbols})


def term_of(symbol: Symbol, place: Place) -> Constant | Variable:
    """The term that a symbol other than a predicate or function stands for."""
    if symbol.role in ("parameter", "run-time variable", "variable"):
        return Variable(symbol.name, str(symbol.kind or ""), place)
    return Constant(symbol.name, place)
