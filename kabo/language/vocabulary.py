"""The declared names that formulas may use: types, predicates, functions, objects [docs/reference/files.md#rules].

In YAML files predicates, functions, objects and variables share one namespace. In PDDL and PKS, objects and
variables have a namespace each, and the name in kabo may differ from that in the file. A name with a faulty
declaration is kept, as far as it is known, so that one mistake is reported only once.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from kabo.language.findings import Findings, spell_place
from kabo.language.formulas import Application, Constant, Place, Variable
from kabo.language.names import Names
from kabo.language.problem import Function
from kabo.language.task_description import Signature
from kabo.language.types import ANY, NUMBERS, Kind, Types, Values

Role = Literal[
    "predicate", "function", "procedure", "constant", "object", "value", "parameter", "run-time variable", "variable"
]  # fmt: skip


@dataclass(frozen=True)
class Symbol:
    """The meaning of a name.

    Attributes:
        role: the part of the language to which the name belongs, such as predicate or function.
        name: the name in kabo.
        place: the place of the declaration; None for built-in names.
        kind: the kind of the symbol's values; empty for a predicate.
        arguments: the kinds of the arguments of a predicate, function or procedure.
        value_of: the term whose value a run-time variable has.
        original: the name in the file if it differs from `name`, else None.
        type: for a variable, the nearest common supertype of the types of `kind`.
    """

    role: Role
    name: str
    place: Place | None
    kind: Kind = ANY
    arguments: tuple[Kind, ...] = ()
    value_of: Application | None = None
    original: str | None = None
    type: str = ""

    @property
    def written(self) -> str:
        """The name of the symbol in the file."""
        return self.name if self.original is None else self.original

    @property
    def description(self) -> str:
        """The role with its article, such as `an object` or `a predicate`."""
        return ("an " if self.role == "object" else "a ") + self.role

    @property
    def variable(self) -> Variable:
        """The symbol as a variable."""
        return Variable(self.name, self.type, self.place)

    def term(self, place: Place | None) -> Constant | Variable:
        """The symbol as a term: an object, constant or variable, without arguments."""
        if self.role in ("parameter", "run-time variable", "variable"):
            return Variable(self.name, self.type, place)
        return Constant(self.name, place)


@dataclass
class Vocabulary:
    """All names that are declared by a domain and by a problem for it.

    Attributes:
        findings: the collection that receives findings.
        types: the declared types.
        names: the namespace in which every name of a PDDL or PKS file gets a unique name in kabo.
        symbols: the predicates and functions by their names in the file; for YAML files also all other names.
        objects: the objects of PDDL and PKS files, by their names in the file.
        procedures: the signatures of geometric procedures; None for a faulty task file, which was reported.
    """

    findings: Findings
    types: Types = field(default_factory=Types)
    names: Names = field(default_factory=Names)
    symbols: dict[str, Symbol] = field(default_factory=dict)
    objects: dict[str, Symbol] = field(default_factory=dict)
    procedures: Mapping[str, Signature | None] = field(default_factory=dict)

    # ------------------------------------------------------------------------------------------------- declaring
    def declare(self, symbol: Symbol) -> bool:
        """Adds a symbol to the namespace and returns True; if its name is already declared, reports it: False."""
        earlier = self.symbols.get(symbol.name)
        if earlier is None:
            self.symbols[symbol.name] = symbol
            return True
        self.report_taken(symbol, earlier)
        return False

    def report_taken(self, symbol: Symbol, earlier: Symbol) -> None:
        """Reports that the name of `symbol` already means `earlier`."""
        assert symbol.place is not None and earlier.place is not None
        message = f'"{symbol.name}" is already the name of {earlier.description}'
        hint = f"declared at {spell_place(earlier.place)}; predicates, functions, objects, variables share names"
        self.findings.add(symbol.place, message, hint)

    def check_type(self, name: str, place: Place, where: str, *also: str) -> bool:
        """Whether `name` is a type; if not, this is reported, and the remedy may be a type or a word of `also`."""
        known = self.types.known
        if name in known:
            return True
        declared = {each: (each, self.types.places.get(each)) for each in known if self.findings.may_suggest}
        if name in self.symbols:
            hint: str | None = f'"{name}" is {self.symbols[name].description}'
        else:
            hint = self.findings.near(name, [*declared, *also], declared)
        self.findings.add(place, f'unknown type "{name}" {where}', hint)
        return False

    def report_renamed(self) -> None:
        """Warns of every name whose spelling in kabo is not the usual one, because that is already in use."""
        places = {each.written: each.place for each in self.all_of("predicate", "function")}
        places |= {name: each.place for name, each in self.objects.items()}
        for names, at in ((self.types.names, self.types.places), (self.names, places)):
            for name, original in names.originals.items():
                place = at.get(original)
                plain = names.plain(original)
                if name == plain or place is None:
                    continue
                owner = names.originals.get(plain)
                reason = (
                    f'"{plain}" is taken by "{owner}"'
                    if owner is not None
                    else f'"{plain}" has a meaning of its own'
                )
                message = f'"{original}" is called "{name}" in kabo and in its plans'
                self.findings.add(place, message, reason, warning=True)

    # ------------------------------------------------------------------------------------------------- looking up
    def all_of(self, *roles: Role) -> Iterator[Symbol]:
        """The symbols with one of the roles, in the order of the file."""
        return (symbol for symbol in self.symbols.values() if symbol.role in roles)

    def is_predicate(self, name: str) -> bool:
        """Whether a predicate of that name is declared; names that are also keywords of the language are found too."""
        symbol = self.symbols.get(name)
        return symbol is not None and symbol.role == "predicate"

    def function(self, name: str) -> Symbol | None:
        """The function with the given name in the file; None if there is none."""
        symbol = self.symbols.get(name)
        return symbol if symbol is not None and symbol.role == "function" else None

    def written(self, *roles: Role) -> list[str]:
        """The names in the file of all symbols with one of the roles."""
        return [symbol.written for symbol in self.all_of(*roles)]

    # ---------------------------------------------------------------------------------------------------- remedies
    def signature(self, symbol: Symbol) -> str:
        """The declaration of a symbol as text: `robot_grasps(robot, bottle)`."""
        kinds = ", ".join(self.types.common(kind) or "?" for kind in symbol.arguments)
        return f"{symbol.written}({kinds})" if kinds else symbol.written

    def declared_at(self, symbol: Symbol) -> str | None:
        """The remedy that shows the declaration of a symbol and its place; None for a built-in symbol."""
        if symbol.place is None:
            return None
        return f"{self.signature(symbol)} is declared at {spell_place(symbol.place)}"

    def near(self, word: str, known: Iterable[str], *, all_if_few: bool = True) -> str | None:
        """The remedy `did you mean …` for an unknown name; it quotes declared predicates and functions."""
        declared: dict[str, tuple[str, Place | None]] = {}
        if self.findings.may_suggest:
            declared = {
                each.written: (self.signature(each), each.place) for each in self.all_of("predicate", "function")
            }
        return self.findings.near(word, list(known), declared, all_if_few=all_if_few)

    # -------------------------------------------------------------------------------------------- as a domain has them
    def predicates_of_domain(self) -> dict[str, tuple[str, ...]]:
        """All predicates, by their names in kabo, with the types of their arguments."""
        common = self.types.common
        return {each.name: tuple(map(common, each.arguments)) for each in self.all_of("predicate")}

    def functions_of_domain(self) -> dict[str, Function]:
        """All functions, by their names in kabo, with the types of their arguments and values."""
        common = self.types.common
        found = {}
        for each in self.all_of("function"):
            values = each.kind.names if isinstance(each.kind, Values) else None
            value_type = None if values is not None or each.kind == NUMBERS else common(each.kind)
            found[each.name] = Function(each.name, tuple(map(common, each.arguments)), value_type, values)
        return found

    def types_of_objects(self) -> dict[str, str]:
        """The type of every object, by kabo's names; an empty text for an object declared with an unknown type."""
        return {each.name: each.type for each in self.objects.values()}
