"""Names and types of formulas: from expressions as they are written to terms, atoms and comparisons.

All syntaxes share one resolver; a `Dialect` defines what a syntax permits, and the wording of its messages.
Methods that find an error report it, still check the other parts of the expression, and return None.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from kabo.language import formulas as f
from kabo.language.expressions import ARITHMETIC, COMPARISONS, Expression, Span
from kabo.language.findings import Findings
from kabo.language.source import SourceFile
from kabo.language.types import ANY, NUMBERS, OBJECT, TEST, Kind, Values
from kabo.language.vocabulary import Role, Symbol, Vocabulary

Typed = tuple[f.Term, Kind]


class Dialect:
    """A syntax's rules for names and types, and its error messages; the defaults are those of PDDL and PKS.

    Attributes:
        one_namespace: whether variables, objects, predicates and functions share one namespace.
        only_numbers: whether a numeral is always a number where a number is expected, even if an object has that name.
        longest_quote: the greatest number of characters of a formula in a quotation; None for no limit.
    """

    one_namespace = False
    only_numbers = False
    longest_quote: int | None = 60

    def unknown_term(self, here: "NameResolver", node: Expression) -> None:
        """Reports an unknown word or call in the place of a term."""
        raise NotImplementedError

    def no_value(self, here: "NameResolver", node: Expression, symbol: Symbol) -> None:
        """Reports a predicate, or a procedure that is a test, in the place of a term."""
        here.report(node, f'"{node.text}" is a predicate: it is true or false, and no value')

    def no_atom(self, here: "NameResolver", node: Expression, symbol: Symbol | None) -> None:
        """Reports a node that is not a predicate in the place of an atom; `symbol` is its declaration."""
        raise NotImplementedError

    def no_function(self, here: "NameResolver", node: Expression, symbol: Symbol | None) -> None:
        """Reports a node that is not a function where one is required.

        `symbol` is what the node's name is declared as; None if it is not declared, or the node has no name.
        """
        raise NotImplementedError

    def no_number(self, here: "NameResolver", node: Expression, kind: Kind) -> None:
        """Reports a term whose value is no number."""
        here.report(node, f'"{here.quote(node)}" is no number, expected one')

    def no_size(self, here: "NameResolver", node: Expression, part: Expression, kind: Kind) -> None:
        """Reports `part`, a side of a comparison by size (`<`, `<=`, …), whose value is not a number."""
        here.report(part, f'"{node.kind}" compares numbers, "{here.quote(part)}" is none')

    def never_equal(self, here: "NameResolver", node: Expression, left: Kind, right: Kind) -> f.Truth | None:
        """The truth value of a comparison whose sides can never be equal; None after a report."""
        return f.Truth(node.kind == "!=", here.place(node))

    def wrong_count(self, here: "NameResolver", node: Expression, symbol: Symbol) -> None:
        """Reports that a call has too many arguments or too few."""
        here.report(node, count_fault(node, symbol), here.vocabulary.declared_at(symbol))

    def wrong_argument(
        self, here: "NameResolver", node: Expression, number: int, symbol: Symbol, kind: Kind
    ) -> None:
        """Reports that the argument `number` (counted from 0) is of another kind than declared."""
        wanted, part = symbol.arguments[number], node.parts[number]
        message = f"argument {number + 1} of {symbol.written} must be of type {one_of(wanted)}"
        message += f', "{here.quote(part)}" is of type {one_of(kind)}'
        here.report(part, message, here.vocabulary.declared_at(symbol))

    def operand_fault(self, operator: str, count: int) -> str | None:
        """The message for a wrong number of operands; None if the syntax permits it."""
        return None

    def size_fault(self, term: f.Term) -> str | None:
        """The message for an arithmetic term that is too large; None if it is not."""
        return None


def count_fault(node: Expression, symbol: Symbol) -> str:
    """The message for a wrong number of arguments, such as `at takes 2 arguments, not 1`."""
    count = len(symbol.arguments)
    plural = "" if count == 1 else "s"
    return f"{symbol.written} takes {count or 'no'} argument{plural}, not {len(node.parts) or 'none'}"


def one_of(kind: Kind) -> str:
    """The types of a kind as text, joined by `or`, such as `truck or plane`; an enumeration as its values."""
    return str(kind) if isinstance(kind, Values) else " or ".join(kind)


@dataclass(frozen=True)
class NameResolver:
    """Resolves names and types of expressions in one scope of one file.

    Attributes:
        source: the file that contains the expressions.
        text: the text of the file, in which text outside of formulas may be replaced by blanks.
        vocabulary: all names that are declared.
        where: the end of messages such as "unknown predicate "p" …": `in a precondition of action "pick_up"`.
        dialect: the rules of the syntax, and the wording of its messages.
        scope: the bound variables, by their names in the file.
        free: the collection that receives unbound variables; if it is None, they are reported as unknown.
        in_update: whether the expression is an atom of add or del, in which run-time variables are not allowed.
        hints: remedies for names that are known in other parts of the same formula.
        fallback: the remedy for unknown names without a similar known name.
    """

    source: SourceFile
    text: str
    vocabulary: Vocabulary
    where: str
    dialect: Dialect
    scope: Mapping[str, Symbol] = field(default_factory=dict)
    free: dict[str, Symbol] | None = None
    in_update: bool = False
    hints: Mapping[str, str] = field(default_factory=dict)
    fallback: str | None = None

    @property
    def findings(self) -> Findings:
        """The collection that receives findings."""
        return self.vocabulary.findings

    def report(self, piece: Span, message: str, hint: str | None = None, *, warning: bool = False) -> None:
        """Records a finding at a piece of the text."""
        self.findings.add(self.place(piece), message, hint, warning=warning)

    def place(self, piece: Span) -> f.Place:
        """The place of the piece in the file."""
        return self.source.place(piece.start, piece.end)

    def quote(self, piece: Span) -> str:
        """The text of a piece in the file, on one line, shortened to the length that the dialect permits."""
        written = " ".join(self.text[piece.start : piece.end].split())
        most = self.dialect.longest_quote
        return written if most is None or len(written) <= most else f"{written[: most - 3]}…"

    def inside(self, scope: Mapping[str, Symbol]) -> "NameResolver":
        """This resolver with more variables in scope."""
        return replace(self, scope={**self.scope, **scope})

    # ------------------------------------------------------------------------------------------------------- names
    def find(self, name: str) -> Symbol | None:
        """The predicate, function or procedure `name`; any symbol if all share one namespace."""
        bound = self.scope.get(name) if self.dialect.one_namespace else None
        return bound or self.vocabulary.symbols.get(name)

    def _find_value(self, node: Expression, wanted: Kind) -> Symbol | None:
        """The symbol that a word or call in the place of a term names, whether or not it may stand there."""
        if node.kind == "call":
            return self.find(node.text)
        name = node.text
        symbol = self.scope.get(name)
        if symbol is None and not (wanted == NUMBERS and self.dialect.only_numbers):
            symbol = self.vocabulary.objects.get(name)
        if symbol is None and node.kind != "number":
            symbol = self.vocabulary.symbols.get(name)
        return symbol

    def visible(self, *roles: Role) -> dict[str, tuple[str, f.Place | None]]:
        """Signature and place of every symbol and variable in scope that has one of `roles` (empty: any role)."""
        all_of = {**self.vocabulary.symbols, **self.scope}
        signature = self.vocabulary.signature
        return {name: (signature(s), s.place) for name, s in all_of.items() if not roles or s.role in roles}

    # ------------------------------------------------------------------------------------------------------- terms
    def term(self, node: Expression, wanted: Kind = ANY) -> Typed | None:
        """A term and the kind of its values; an unbound variable gets the kind `wanted`."""
        if node.kind in ARITHMETIC:
            return self._arithmetic(node)
        symbol = self._find_value(node, wanted)
        if symbol is None:
            return self._undeclared(node, wanted)
        role = symbol.role
        if role in ("function", "procedure") and symbol.kind != TEST:
            return self._application(node, symbol)
        if role in ("predicate", "procedure"):
            self.dialect.no_value(self, node, symbol)
        elif node.kind == "call":
            self.report(node.name, f'"{node.text}" is {symbol.description} and takes no arguments')
        elif role == "run-time variable" and self.in_update:
            self._report_run_time_variable(node, symbol)
        else:
            return symbol.term(self.place(node)), symbol.kind
        return None

    def _undeclared(self, node: Expression, wanted: Kind) -> Typed | None:
        if node.kind == "number":
            value = float(node.text)
            if math.isfinite(value):
                return f.Number(value + 0.0, self.place(node)), NUMBERS
            self.report(node, "this number is too large")
        elif node.kind == "variable" and self.free is not None:
            if node.text not in self.free:
                self.free[node.text] = self._free_variable(node, wanted, self.free)
            symbol = self.free[node.text]
            return symbol.term(self.place(node)), symbol.kind
        else:
            self.dialect.unknown_term(self, node)
        return None

    def _free_variable(self, node: Expression, wanted: Kind, free: Mapping[str, Symbol]) -> Symbol:
        types = self.vocabulary.types
        kind = types.known[OBJECT] if wanted in (ANY, NUMBERS) else types.common(wanted)
        taken = [symbol.name for symbol in (*self.scope.values(), *free.values())]
        name = self.vocabulary.names.free(node.text.lstrip("?"), taken)
        return Symbol("variable", name, self.place(node), (kind,), type=kind)

    def _report_run_time_variable(self, node: Expression, symbol: Symbol) -> None:
        kind = "type" if symbol.kind == ANY or isinstance(symbol.kind, Values) else symbol.type
        hint = f"name each value that it may have: `forall({kind} x) when f(…) = x then p(x)` for its term f(…)"
        message = f'the run-time variable "{node.text}" may not stand inside an atom of add or del'
        self.report(node, message, hint)

    def _application(self, node: Expression, symbol: Symbol) -> Typed | None:
        arguments = self.arguments(node, symbol)
        if arguments is None:
            return None
        applied = f.Application if symbol.role == "function" else f.External
        return applied(symbol.name, arguments, self.place(node)), symbol.kind

    def _arithmetic(self, node: Expression) -> Typed | None:
        operands = [self.number(part) for part in node.parts]
        fault = self.dialect.operand_fault(node.kind, len(operands))
        if fault is not None:
            self.report(node, fault)
            return None
        terms = [operand for operand in operands if operand is not None]
        if len(terms) < len(operands):
            return None
        place = self.place(node)
        if node.kind == "-" and len(terms) == 1:
            if isinstance(terms[0], f.Number):
                return f.Number(-terms[0].value + 0.0, place), NUMBERS
            terms.insert(0, f.Number(0.0, place))
        whole = terms[0]
        for term in terms[1:]:
            whole = f.Arithmetic(node.kind, whole, term, place)  # type: ignore[arg-type]
        fault = self.dialect.size_fault(whole)
        if fault is not None:
            self.report(node, fault)
            return None
        return whole, NUMBERS

    def number(self, node: Expression) -> f.Term | None:
        """A term whose value is a number."""
        found = self.term(node, NUMBERS)
        if found is not None and found[1] not in (NUMBERS, ANY):
            self.dialect.no_number(self, node, found[1])
            return None
        return None if found is None else found[0]

    def arguments(self, node: Expression, symbol: Symbol) -> tuple[f.Term, ...] | None:
        """The arguments of a predicate, function or procedure, checked against its declaration."""
        wanted, types = symbol.arguments, self.vocabulary.types
        if len(node.parts) != len(wanted):
            self.dialect.wrong_count(self, node, symbol)
            return None
        found = [self.term(part, kind) for part, kind in zip(node.parts, wanted, strict=True)]
        terms: list[f.Term] = []
        for number, (each, kind) in enumerate(zip(found, wanted, strict=True)):
            if each is None:
                continue
            if not types.fits(each[1], kind):
                self.dialect.wrong_argument(self, node, number, symbol, each[1])
                return None
            terms.append(each[0])
        return tuple(terms) if len(terms) == len(found) else None

    def application(self, node: Expression) -> f.Application | None:
        """A function applied to its arguments, as in Kv(…)."""
        symbol = self.find(node.text) if node.kind in ("name", "call") else None
        if symbol is None or symbol.role != "function":
            self.dialect.no_function(self, node, symbol)
            return None
        found = self._application(node, symbol)
        return found[0] if found is not None and isinstance(found[0], f.Application) else None

    # ------------------------------------------------------------------------------------------------------ claims
    def atom(self, node: Expression) -> f.Atom | None:
        """A predicate with its arguments."""
        symbol = self.find(node.text) if node.kind in ("name", "call") else None
        if symbol is None or symbol.role != "predicate":
            self.dialect.no_atom(self, node, symbol)
            return None
        arguments = self.arguments(node, symbol)
        return None if arguments is None else f.Atom(symbol.name, arguments, self.place(node))

    def claim(self, node: Expression) -> f.Claim | f.Truth | None:
        """A literal or a comparison; `true` or `false` if the dialect permits sides that are never equal."""
        if node.kind in COMPARISONS:
            return self.comparison(node)
        inner = node.parts[0] if node.kind == "!" else node
        if node.kind == "!" and inner.kind in ("=", "!="):
            claim = self.comparison(inner)
            if isinstance(claim, f.Comparison):
                return replace(claim, operator="!=" if claim.operator == "=" else "=")
            return f.Truth(not claim.value, claim.place) if isinstance(claim, f.Truth) else None
        atom = self.atom(inner)
        return None if atom is None else f.Literal(atom, node.kind != "!", self.place(node))

    def comparison(self, node: Expression) -> f.Comparison | f.Truth | None:
        """A comparison of any values for equality, or of numbers by size."""
        sides = replace(self, in_update=False) if self.in_update else self  # a value may be a run-time variable
        left = sides.term(node.parts[0])
        if left is not None and isinstance(
            left[1], Values
        ):  # a closed list: the remedy for what is not among them
            listed = f"{self.quote(node.parts[0])} is one of {', '.join(left[1].names)}"
            sides = replace(sides, fallback=listed)
        right = sides.term(node.parts[1], ANY if left is None else left[1])
        if left is None or right is None:
            return None
        if node.kind not in ("=", "!="):
            for part, (_, kind) in zip(node.parts, (left, right), strict=True):
                if kind not in (NUMBERS, ANY):
                    self.dialect.no_size(self, node, part, kind)
                    return None
        elif not self.vocabulary.types.comparable(left[1], right[1]):
            return self.dialect.never_equal(self, node, left[1], right[1])
        return f.Comparison(node.kind, left[0], right[0], self.place(node))  # type: ignore[arg-type]
