"""The rules of kabo's YAML files for names and types (one namespace for all names), and their error messages."""

from kabo.language import formulas as f
from kabo.language.expressions import Expression
from kabo.language.resolver import Dialect, NameResolver, count_fault, one_of
from kabo.language.types import TEST, Kind, Values
from kabo.language.vocabulary import Role, Symbol


class YamlDialect(Dialect):
    """The dialect of YAML files: findings are placed at names; arguments of unknown names are checked as well."""

    one_namespace = True
    longest_quote = None

    def unknown_term(self, here: NameResolver, node: Expression) -> None:
        """Reports an unknown name or function, and checks its arguments."""
        report_unknown(here, node, "name" if node.kind == "name" else "function")
        _check_arguments(here, node)

    def no_value(self, here: NameResolver, node: Expression, symbol: Symbol) -> None:
        """Reports a predicate or test in the place of a term; the remedy shows how to write a test."""
        if symbol.role == "predicate":
            here.report(node.name, f'"{node.text}" is a predicate: it is true or false, and no value')
            return
        hint = f"{here.quote(node)} stands by itself, without K"
        here.report(node.name, f'the procedure "{node.text}" is a test: it is true or false, and no value', hint)

    def no_atom(self, here: NameResolver, node: Expression, symbol: Symbol | None) -> None:
        """Reports a number, an unknown name or another symbol in the place of an atom."""
        if node.kind not in ("name", "call"):
            here.report(node, "a predicate must stand here, this is a number")
            return
        if symbol is None:
            report_unknown(here, node, "predicate", "predicate")
        elif symbol.role == "function":
            term = here.quote(node)
            hint: str | None = f"write K({term} = value), or Kv({term}) for whether its value is known"
            here.report(node.name, f'"{node.text}" is a function, not a predicate', hint)
        else:
            hint = f"write {here.quote(node)} without K" if symbol.kind == TEST else None
            here.report(node.name, f'"{node.text}" is {symbol.description}, not a predicate', hint)
        _check_arguments(here, node)

    def no_function(self, here: NameResolver, node: Expression, symbol: Symbol | None) -> None:
        """Reports anything but a function where one is required, as in Kv(…)."""
        if node.kind in ("name", "call") and symbol is None:
            report_unknown(here, node, "function", "function")
        elif symbol is not None and symbol.role == "predicate":
            here.report(node.name, f'"{node.text}" is a predicate', f"write Kw({here.quote(node)})")
        elif symbol is not None and symbol.role == "procedure":
            message = f'"{node.text}" is a procedure: what it answers is known whenever it is asked'
            here.report(node.name, message)
        else:
            here.report(node, "a function must stand here")

    def no_number(self, here: NameResolver, node: Expression, kind: Kind) -> None:
        """Reports a term whose value is not a number, with the kind of its values."""
        here.report(node, f"a number must stand here, this is {with_article(kind)}")

    def no_size(self, here: NameResolver, node: Expression, part: Expression, kind: Kind) -> None:
        """Reports a side of a comparison by size whose value is not a number, with the kind of its values."""
        here.report(part, f'"{node.kind}" compares numbers, this is {with_article(kind)}')

    def never_equal(self, here: NameResolver, node: Expression, left: Kind, right: Kind) -> f.Truth | None:
        """Reports a comparison that can never hold as an error."""
        kinds = f"{with_article(left)}, the other {with_article(right)}"
        here.report(node, f"these can never be equal: one side is {kinds}")
        return None

    def wrong_count(self, here: NameResolver, node: Expression, symbol: Symbol) -> None:
        """Reports a wrong number of arguments; checks each of them as well."""
        _check_arguments(here, node)
        here.report(node.name, count_fault(node, symbol), here.vocabulary.declared_at(symbol))

    def wrong_argument(
        self, here: NameResolver, node: Expression, number: int, symbol: Symbol, kind: Kind
    ) -> None:
        """Reports an argument of a wrong kind; the message gives its number if there are several arguments."""
        what = f"argument {number + 1} of" if len(node.parts) > 1 else "the argument of"
        message = f"{what} {symbol.written} must be {with_article(symbol.arguments[number])}"
        hint = here.vocabulary.declared_at(symbol)
        here.report(node.parts[number], f"{message}, this is {with_article(kind)}", hint)


def _check_arguments(here: NameResolver, node: Expression) -> None:
    for part in node.parts:
        here.term(part)


def report_unknown(here: NameResolver, node: Expression, what: str, *roles: Role) -> None:
    """Reports an unknown name that should be one of `roles`."""
    message, findings = f'unknown {what} "{node.text}" {here.where}', here.findings
    if not findings.may_suggest:
        here.report(node.name, message)
        return
    known = here.visible(*roles)
    hint = here.hints.get(node.text) or findings.near(node.text, known.keys(), known, all_if_few=bool(roles))
    if hint is None and roles:
        everything = here.visible()
        hint = findings.near(node.text, everything.keys(), everything)
    here.report(node.name, message, hint or here.fallback)


def with_article(kind: Kind) -> str:
    """A kind as text with its article, such as `a bottle`, `an object` or `one of {oslo, rome}`."""
    if isinstance(kind, Values):
        return f"one of {kind}"
    name = one_of(kind)
    return f"{'an' if name[:1] in 'aeiou' else 'a'} {name}"


YAML = YamlDialect()
