"""Terms, atoms and claims: parse trees with every name resolved and every type checked.

A function returns None after reporting what is wrong, and goes on with the parts beside it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from kabo.language import formulas as f
from kabo.language.findings import Findings, spell_place
from kabo.language.names import NAME, proper_name
from kabo.language.task_description import Signature
from kabo.language.vocabulary import NUMBER, TEST, Kind, Scope, Symbol, Values, Vocabulary, term_of
from kabo.language.yaml.syntax import Parsed, Token, Tree


@dataclass(frozen=True)
class Context:
    """What is known around a piece of a formula.

    Attributes:
        where: completes "unknown predicate "p" …": `in a precondition of action "pick_up"`.
        hint_of: remedies for names that would be known elsewhere in the same formula.
        in_update: inside an atom of add or del, where no run-time variable may stand.
        fallback: the remedy for unknown names that nothing is near to.
    """

    parsed: Parsed
    scope: Scope
    where: str
    hint_of: Mapping[str, str]
    in_update: bool = False
    fallback: str | None = None

    @property
    def findings(self) -> Findings:
        """Where findings go."""
        return self.scope.vocabulary.findings

    @property
    def vocabulary(self) -> Vocabulary:
        """Types and declared names."""
        return self.scope.vocabulary

    @property
    def procedures(self) -> Mapping[str, Signature | None]:
        """What geometric procedures there are."""
        return self.vocabulary.procedures

    def report(self, piece: Tree | Token, message: str, hint: str | None = None) -> None:
        """Reports something at a piece of the formula."""
        self.findings.add(self.parsed.place(piece), message, hint)

    def text(self, piece: Tree) -> str:
        """The piece as it is written, on one line."""
        place = self.parsed.scalar
        begin = place.start + (0 if piece.meta.empty else piece.meta.start_pos)
        end = place.end if piece.meta.empty else place.start + piece.meta.end_pos
        return " ".join(place.source.text[begin:end].split())

    def inside(self, scope: Scope) -> "Context":
        """This context with another scope."""
        return replace(self, scope=scope)

    def unknown(self, token: Tree | Token, role: str, *roles: str) -> None:
        """Reports an unknown name that should be one of `roles`."""
        if not self.findings.may_suggest:
            self.report(token, f'unknown {role} "{token}" {self.where}')
            return
        known = self.scope.names(*roles)
        hint = self.hint_of.get(str(token)) or self.findings.near(
            str(token), known.keys(), known, all_if_few=bool(roles)
        )
        if hint is None and roles:
            everything = self.scope.names()
            hint = self.findings.near(str(token), everything.keys(), everything)
        self.report(token, f'unknown {role} "{token}" {self.where}', hint or self.fallback)


def kind_with_article(kind: Kind) -> str:
    """`a bottle`, `an object`, `one of {oslo, rome}`."""
    if not isinstance(kind, str):
        return f"one of {kind}"
    return f"{'an' if kind[:1] in 'aeiou' else 'a'} {kind}"


# --------------------------------------------------------------------------------------------------------- terms
def read_term(context: Context, tree: Tree) -> tuple[f.Term | None, Kind]:
    """A term and what its values are; (None, None) after a report."""
    place = context.parsed.place(tree)
    if tree.data == "number":
        return _number(context, tree, 1.0)
    if tree.data == "signed":
        return _signed(context, tree)
    if tree.data == "arithmetic":
        left, right = _numeric(context, tree.children[0]), _numeric(context, tree.children[2])
        if left is None or right is None:
            return None, None
        return f.Arithmetic(str(tree.children[1]), left, right, place), NUMBER  # type: ignore[arg-type]
    return _named_term(context, tree)


def _number(context: Context, tree: Tree, sign: float) -> tuple[f.Term | None, Kind]:
    value = sign * float(str(tree.children[0])) + 0.0
    if not math.isfinite(value):
        context.report(tree, "this number is too large")
        return None, None
    return f.Number(value, context.parsed.place(tree)), NUMBER


def _signed(context: Context, tree: Tree) -> tuple[f.Term | None, Kind]:
    sign, inner = tree.children
    term = _numeric(context, inner)
    if term is None or sign == "+":
        return term, NUMBER
    place = context.parsed.place(tree)
    if isinstance(term, f.Number):
        return f.Number(-term.value + 0.0, place), NUMBER
    return f.Arithmetic("-", f.Number(0.0, place), term, place), NUMBER


def _numeric(context: Context, tree: Tree) -> f.Term | None:
    term, kind = read_term(context, tree)
    if term is not None and kind not in (NUMBER, None):
        context.report(tree, f"a number must stand here, this is {kind_with_article(kind)}")
        return None
    return term


def _named_term(context: Context, tree: Tree) -> tuple[f.Term | None, Kind]:
    name = tree.children[0]
    symbol = context.scope.find(str(name))
    if symbol is None:
        context.unknown(name, "name" if len(tree.children) == 1 else "function")
        for argument in tree.children[1:]:
            read_term(context, argument)
        return None, None
    if symbol.role == "predicate":
        context.report(name, f'"{name}" is a predicate: it is true or false, and no value')
        return None, None
    if symbol.kind == TEST:
        hint = f"{context.text(tree)} stands by itself, without K"
        context.report(name, f'the procedure "{name}" is a test: it is true or false, and no value', hint)
        return None, None
    if symbol.role in ("function", "procedure"):
        arguments = read_arguments(context, tree, symbol)
        if arguments is None:
            return None, None
        kind_of_term = f.Application if symbol.role == "function" else f.External
        return kind_of_term(str(name), arguments, context.parsed.place(tree)), symbol.kind
    if len(tree.children) > 1:
        context.report(name, f'"{name}" is {symbol.description} and takes no arguments')
        return None, None
    if symbol.role == "run-time variable" and context.in_update:
        kind = symbol.kind if isinstance(symbol.kind, str) else "type"
        hint = f"name each value that it may have: `forall({kind} x) when f(…) = x then p(x)` for its term f(…)"
        context.report(name, f'the run-time variable "{name}" may not stand inside an atom of add or del', hint)
        return None, None
    return term_of(symbol, context.parsed.place(tree)), symbol.kind


def read_arguments(context: Context, tree: Tree, symbol: Symbol) -> tuple[f.Term, ...] | None:
    """The arguments of a predicate or function, checked against its declaration."""
    given = tree.children[1:]
    terms = [read_term(context, argument) for argument in given]
    if len(given) != len(symbol.arguments):
        count = len(symbol.arguments)
        message = (
            f"{symbol.name} takes {count or 'no'} argument{'' if count == 1 else 's'}, not {len(given) or 'none'}"
        )
        hint = f"{symbol.signature} is declared at {spell_place(symbol.place)}"
        context.report(tree.children[0], message, hint)
        return None
    for number, (argument, (term, kind), wanted) in enumerate(zip(given, terms, symbol.arguments, strict=True), 1):
        if term is not None and not context.vocabulary.fits(kind, wanted):
            what = f"argument {number} of {symbol.name}" if len(given) > 1 else f"the argument of {symbol.name}"
            message = f"{what} must be {kind_with_article(wanted)}, this is {kind_with_article(kind)}"
            context.report(argument, message, f"{symbol.signature} is declared at {spell_place(symbol.place)}")
            return None
    return tuple(term for term, _ in terms if term is not None) if all(term for term, _ in terms) else None


# -------------------------------------------------------------------------------------------------------- claims
def read_atom(context: Context, tree: Tree) -> f.Atom | None:
    """A predicate with its arguments."""
    if tree.data != "term":
        context.report(tree, "a predicate must stand here, this is a number")
        return None
    name = tree.children[0]
    symbol = context.scope.find(str(name))
    if symbol is None:
        context.unknown(name, "predicate", "predicate")
    elif symbol.role == "function":
        context.report(name, f'"{name}" is a function, not a predicate', _value_hint(context, tree))
    elif symbol.role != "predicate":
        hint = f"write {context.text(tree)} without K" if symbol.kind == TEST else None
        context.report(name, f'"{name}" is {symbol.description}, not a predicate', hint)
    else:
        arguments = read_arguments(context, tree, symbol)
        return None if arguments is None else f.Atom(str(name), arguments, context.parsed.place(tree))
    for argument in tree.children[1:]:
        read_term(context, argument)
    return None


def _value_hint(context: Context, tree: Tree) -> str:
    term = context.text(tree)
    return f"write K({term} = value), or Kv({term}) for whether its value is known"


def read_function_term(context: Context, tree: Tree) -> f.Application | None:
    """A function with its arguments, as Kv takes it."""
    if tree.data == "term":
        name = tree.children[0]
        symbol = context.scope.find(str(name))
        if symbol is None:
            context.unknown(name, "function", "function")
            return None
        if symbol.role == "predicate":
            context.report(name, f'"{name}" is a predicate', f"write Kw({context.text(tree)})")
            return None
        if symbol.role == "procedure":
            context.report(name, f'"{name}" is a procedure: what it answers is known whenever it is asked')
            return None
        if symbol.role == "function":
            term, _ = read_term(context, tree)
            return term if isinstance(term, f.Application) else None
    context.report(tree, "a function must stand here")
    return None


def read_claim(context: Context, tree: Tree) -> f.Claim | None:
    """A literal or a comparison."""
    place = context.parsed.place(tree)
    if tree.data == "compare":
        return _comparison(context, tree)
    if tree.data == "denial":
        atom = read_atom(context, tree.children[0])
        return None if atom is None else f.Literal(atom, False, place)
    atom = read_atom(context, tree)
    return None if atom is None else f.Literal(atom, True, place)


def _comparison(context: Context, tree: Tree) -> f.Comparison | None:
    left_tree, operator, right_tree = tree.children
    free = replace(context, in_update=False)  # a value may be a run-time variable, an atom's argument may not
    left, left_kind = read_term(free, left_tree)
    if isinstance(left_kind, Values):  # the values are a closed list: a hint for what is not among them
        free = replace(free, fallback=f"{context.text(left_tree)} is one of {', '.join(left_kind.names)}")
    right, right_kind = read_term(free, right_tree)
    if left is None or right is None:
        return None
    if operator not in ("=", "!="):
        for piece, kind in ((left_tree, left_kind), (right_tree, right_kind)):
            if kind not in (NUMBER, None):
                context.report(piece, f'"{operator}" compares numbers, this is {kind_with_article(kind)}')
                return None
    elif not context.vocabulary.comparable(left_kind, right_kind):
        kinds = f"{kind_with_article(left_kind)}, the other {kind_with_article(right_kind)}"
        context.report(tree, f"these can never be equal: one side is {kinds}")
        return None
    return f.Comparison(str(operator), left, right, context.parsed.place(tree))  # type: ignore[arg-type]


# ------------------------------------------------------------------------------------------------------ variables
def read_variables(context: Context, tree: Tree) -> tuple[tuple[f.Variable, ...], Context]:
    """The variables of a quantifier, and the context in which they are bound."""
    found: dict[str, Symbol] = {}
    pairs = list(zip(tree.children[::2], tree.children[1::2], strict=True))
    for kind, name in pairs:
        known = context.vocabulary.check_type(str(kind), context.parsed.place(kind), context.where)
        if not NAME.fullmatch(str(name)):
            context.report(name, f'"{name}" cannot be the name of a variable', f'write "{proper_name(str(name))}"')
        symbol = Symbol("variable", str(name), context.parsed.place(name), str(kind) if known else None)
        if str(name) in found:
            context.vocabulary.report_taken(symbol, found[str(name)])
        found[str(name)] = symbol
    variables = tuple(f.Variable(str(name), str(kind), context.parsed.place(name)) for kind, name in pairs)
    return variables, context.inside(context.scope.with_bound(found))
