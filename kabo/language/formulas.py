"""Formula trees: terms, claims, formulas, facts, effects and procedure calls, as plain values.

The parser makes them, the checker has resolved every name, the knowledge planner compiles them. Two trees are
equal when they have the same content; places in the file are not compared.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal as OneOf


@dataclass(frozen=True)
class Place:
    """A position in a file; line and column count from 1."""

    file: str
    line: int
    column: int
    length: int = 1


_place = field(default=None, compare=False, repr=False)


# ------------------------------------------------------------------------------------------------------- terms
@dataclass(frozen=True)
class Constant:
    """An object, a constant of the domain, or a value of an enumeration."""

    name: str
    place: Place | None = _place


@dataclass(frozen=True)
class Variable:
    """A parameter of an action, or a variable that a quantifier binds."""

    name: str
    type: str
    place: Place | None = _place


@dataclass(frozen=True)
class Number:
    """A number; SI units, angles in radians."""

    value: float
    place: Place | None = _place


@dataclass(frozen=True)
class Application:
    """A function applied to terms: `one_below(this)`."""

    function: str
    arguments: tuple["Term", ...] = ()
    place: Place | None = _place


@dataclass(frozen=True)
class Arithmetic:
    """A sum, difference, product or quotient of two terms with number values."""

    operator: OneOf["+", "-", "*", "/"]
    left: "Term"
    right: "Term"
    place: Place | None = _place


@dataclass(frozen=True)
class External:
    """A call of an external procedure of the domain, a pure function: `distance(here, there)`."""

    procedure: str
    arguments: tuple["Term", ...] = ()
    place: Place | None = _place


Term = Constant | Variable | Number | Application | Arithmetic | External


# ------------------------------------------------------------------------------------------------------ claims
@dataclass(frozen=True)
class Atom:
    """A predicate applied to terms: `grasped(o)`."""

    predicate: str
    arguments: tuple[Term, ...] = ()
    place: Place | None = _place


@dataclass(frozen=True)
class Literal:
    """An atom or its negation, as a claim about the world."""

    atom: Atom
    positive: bool = True
    place: Place | None = _place


@dataclass(frozen=True)
class Comparison:
    """`left operator right`; `=` and `!=` compare any values, the others numbers."""

    operator: OneOf["=", "!=", "<", "<=", ">", ">="]
    left: Term
    right: Term
    place: Place | None = _place


Claim = Literal | Comparison


# ---------------------------------------------------------------------------------------------------- formulas
@dataclass(frozen=True)
class Know:
    """The primitive query K(claim)."""

    claim: Claim
    place: Place | None = _place


@dataclass(frozen=True)
class KnowWhether:
    """The primitive query Kw(atom)."""

    atom: Atom
    place: Place | None = _place


@dataclass(frozen=True)
class KnowValue:
    """The primitive query Kv(term)."""

    term: Application
    place: Place | None = _place


@dataclass(frozen=True)
class Truth:
    """`true` or `false`."""

    value: bool
    place: Place | None = _place


@dataclass(frozen=True)
class Test:
    """A call of a geometric test, or of an external procedure that answers true or false; it changes no state."""

    call: "ProcedureCall | External"
    place: Place | None = _place


@dataclass(frozen=True)
class Not:
    """Negation of a query: `not K(p)` is not `K(not p)`."""

    body: "Formula"
    place: Place | None = _place


@dataclass(frozen=True)
class And:
    """All of the parts, evaluated in their order up to the first that is false."""

    parts: tuple["Formula", ...]
    place: Place | None = _place


@dataclass(frozen=True)
class Or:
    """At least one of the parts."""

    parts: tuple["Formula", ...]
    place: Place | None = _place


@dataclass(frozen=True)
class Xor:
    """Exactly one of the two queries; both are evaluated [K Table 6.1]."""

    first: "Formula"
    second: "Formula"
    place: Place | None = _place


@dataclass(frozen=True)
class Forall:
    """The body holds for every instance of the variables."""

    variables: tuple[Variable, ...]
    body: "Formula"
    place: Place | None = _place


@dataclass(frozen=True)
class Exists:
    """The body holds for some instance of the variables."""

    variables: tuple[Variable, ...]
    body: "Formula"
    place: Place | None = _place


@dataclass(frozen=True)
class Temporal:
    """`initially(φ)` (K⁰, after postdiction) or `always(φ)` (K*, in every state); goals only."""

    kind: OneOf["initially", "always"]
    body: "Formula"
    place: Place | None = _place


Formula = Know | KnowWhether | KnowValue | Truth | Test | Not | And | Or | Xor | Forall | Exists | Temporal


# ----------------------------------------------------------------------------------------------------- effects
@dataclass(frozen=True)
class FactAll:
    """A conjunction as one fact, of the databases Kw and LCW."""

    parts: tuple["Fact", ...]
    place: Place | None = _place


@dataclass(frozen=True)
class FactForall:
    """`forall(t x) fact` as one fact, of the databases Kf, Kw and LCW."""

    variables: tuple[Variable, ...]
    body: "Fact"
    place: Place | None = _place


@dataclass(frozen=True)
class ExactlyOne:
    """`exactly_one(t x) fact` as one set of the database Kx, of whose members exactly one holds."""

    variables: tuple[Variable, ...]
    body: "Fact"
    place: Place | None = _place


@dataclass(frozen=True)
class TermFact:
    """A function term as a fact of the database Kv: its value is known."""

    term: Application
    place: Place | None = _place


Fact = Literal | Comparison | FactAll | FactForall | ExactlyOne | TermFact

Database = OneOf["Kf", "Kw", "Kv", "Kx", "Kor", "LCW"]


@dataclass(frozen=True)
class Change:
    """`add(DB, facts)` or `del(DB, facts)`. An atom of Kw is a positive Literal, a term of Kv a TermFact."""

    operation: OneOf["add", "del"]
    database: Database
    facts: tuple[Fact, ...]
    place: Place | None = _place


@dataclass(frozen=True)
class WorldEffect:
    """`when C then E`: where C holds in the world E holds afterwards, whatever the agent knows."""

    conditions: tuple[Claim, ...]
    outcomes: tuple[Claim, ...]
    place: Place | None = _place


@dataclass(frozen=True)
class Conditional:
    """`query => updates`: the updates happen if the query holds in the state before."""

    condition: Formula
    updates: tuple["Effect", ...]
    place: Place | None = _place


@dataclass(frozen=True)
class ForEach:
    """`forall(t x) …`: the effects once for every instance of the variables."""

    variables: tuple[Variable, ...]
    effects: tuple["Effect", ...]
    place: Place | None = _place


Effect = Change | WorldEffect | Conditional | ForEach


# ------------------------------------------------------------------------------------------------- procedures
@dataclass(frozen=True)
class Argument:
    """An argument of a procedure call: positional (`name` is None) or by name.

    The value is a Variable (a parameter of the action), a Constant (an object, or the name of a thing in the
    scene) or a Number.
    """

    value: Variable | Constant | Number
    name: str | None = None
    place: Place | None = _place


@dataclass(frozen=True)
class ProcedureCall:
    """`pick(r, o, grasp = side)`: a procedure of the geometry server and its arguments."""

    procedure: str
    arguments: tuple[Argument, ...] = ()
    place: Place | None = _place

    def ground(self, binding: Mapping[str, str]) -> "GroundCall":
        """The call with its variables bound; options sorted by name."""

        def value(argument: Variable | Constant | Number) -> str | float:
            if isinstance(argument, Variable):
                return binding[argument.name]
            return argument.name if isinstance(argument, Constant) else argument.value

        positional = tuple(value(each.value) for each in self.arguments if each.name is None)
        named = sorted((each.name, value(each.value)) for each in self.arguments if each.name is not None)
        return GroundCall(self.procedure, positional, tuple(named))


@dataclass(frozen=True)
class GroundCall:
    """A procedure call without variables, which the planner makes and the geometry server answers."""

    procedure: str
    arguments: tuple[str | float, ...] = ()
    options: tuple[tuple[str, str | float], ...] = ()  # arguments by name, sorted by name

    def __str__(self) -> str:
        named = (f"{name} = {value}" for name, value in self.options)
        return f"{self.procedure}({', '.join([*map(str, self.arguments), *named])})"
