"""Formula trees: terms, claims, formulas, facts, effects and procedure calls, as plain values.

The trees are built by the readers of the file formats, with every name resolved, and compiled by the knowledge
planner. Two trees are equal if they have the same content; places in the file are not compared.
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
    """A number in SI units; angles are in radians."""

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
    """A comparison `left operator right`: `=` and `!=` compare values of any type, the others numbers."""

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
    """The formula `true` or `false`."""

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
    """A conjunction: true if all parts are true; they are evaluated in order up to the first false one."""

    parts: tuple["Formula", ...]
    place: Place | None = _place


@dataclass(frozen=True)
class Or:
    """A disjunction: true if at least one of the parts is true."""

    parts: tuple["Formula", ...]
    place: Place | None = _place


@dataclass(frozen=True)
class Xor:
    """An exclusive or: true if exactly one of the two queries is true; both are evaluated [K Table 6.1]."""

    first: "Formula"
    second: "Formula"
    place: Place | None = _place


@dataclass(frozen=True)
class Forall:
    """A universal quantifier: true if the body holds for every instance of the variables."""

    variables: tuple[Variable, ...]
    body: "Formula"
    place: Place | None = _place


@dataclass(frozen=True)
class Exists:
    """An existential quantifier: true if the body holds for at least one instance of the variables."""

    variables: tuple[Variable, ...]
    body: "Formula"
    place: Place | None = _place


@dataclass(frozen=True)
class Temporal:
    """`initially(φ)` (K⁰: φ was true at the start) or `always(φ)` (K*: φ is true in every state); goals only."""

    kind: OneOf["initially", "always"]
    body: "Formula"
    place: Place | None = _place


Formula = Know | KnowWhether | KnowValue | Truth | Test | Not | And | Or | Xor | Forall | Exists | Temporal


# ----------------------------------------------------------------------------------------------------- effects
@dataclass(frozen=True)
class FactAll:
    """A conjunction as one fact of the database Kw or LCW."""

    parts: tuple["Fact", ...]
    place: Place | None = _place


@dataclass(frozen=True)
class FactForall:
    """`forall(t x) fact` as one fact of the database Kf, Kw or LCW."""

    variables: tuple[Variable, ...]
    body: "Fact"
    place: Place | None = _place


@dataclass(frozen=True)
class ExactlyOne:
    """`exactly_one(t x) fact` as one entry of the database Kx: exactly one of its instances holds."""

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
    """`add(DB, facts)` or `del(DB, facts)`: an atom of Kw is a positive Literal, a term of Kv is a TermFact."""

    operation: OneOf["add", "del"]
    database: Database
    facts: tuple[Fact, ...]
    place: Place | None = _place


@dataclass(frozen=True)
class WorldEffect:
    """`when C then E`: if C holds in the world before the action, E holds after it, whatever the agent knows."""

    conditions: tuple[Claim, ...]
    outcomes: tuple[Claim, ...]
    place: Place | None = _place


@dataclass(frozen=True)
class Conditional:
    """`query => updates`: the updates happen if the query holds in the knowledge state before the action."""

    condition: Formula
    updates: tuple["Effect", ...]
    place: Place | None = _place


@dataclass(frozen=True)
class ForEach:
    """`forall(t x) effects`: the effects happen once for every instance of the variables."""

    variables: tuple[Variable, ...]
    effects: tuple["Effect", ...]
    place: Place | None = _place


Effect = Change | WorldEffect | Conditional | ForEach


# ------------------------------------------------------------------------------------------------- procedures
@dataclass(frozen=True)
class Argument:
    """An argument of a procedure call: positional (`name` is None) or by name.

    The value is a Variable (a parameter of the action), a Constant (an object, or a name in the scene) or a
    Number.
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
        """The call with its variables replaced by their values in `binding`; named arguments are sorted."""

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
