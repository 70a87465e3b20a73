"""PKS's rules for names and types, its error messages, and the binding of its variables."""

from collections.abc import Sequence

from kabo.language.expressions import Expression
from kabo.language.pks.markup import Markup
from kabo.language.resolver import Dialect, NameResolver
from kabo.language.types import ANY, OBJECT, Kind
from kabo.language.vocabulary import Symbol, Vocabulary


class PksDialect(Dialect):
    """The dialect of PKS: objects and variables have namespaces of their own; numbers may be names of objects."""

    only_numbers = True

    def unknown_term(self, here: NameResolver, node: Expression) -> None:
        """Reports an unknown variable, function or constant, or anything else that is not a term."""
        vocabulary, word = here.vocabulary, node.text
        if node.kind == "variable":
            hint = here.findings.near(word, list(here.scope))
            here.report(node, f'unknown variable "{word}" {here.where}', hint)
        elif node.kind == "call":
            hint = vocabulary.near(word, vocabulary.written("function"))
            message = f'unknown function "{word}" {here.where}'
            here.report(node, f"{message}; external procedures are not supported in imported files", hint)
        elif node.kind == "name":
            known = [*vocabulary.objects, *vocabulary.written("function")]
            hint = vocabulary.near(word, known, all_if_few=False)
            here.report(node, f'unknown constant "{word}" {here.where}', hint)
        else:
            here.report(node, f'unexpected "{here.quote(node)}" {here.where}, expected a term')

    def no_atom(self, here: NameResolver, node: Expression, symbol: Symbol | None) -> None:
        """Reports a function, an unknown predicate or anything else in the place of an atom."""
        if symbol is not None:
            remedy = f"compare it: {here.quote(node)} = value"
            here.report(node, f'"{node.text}" is a function, not a predicate', remedy)
        elif node.kind in ("name", "call"):
            hint = here.vocabulary.near(node.text, here.vocabulary.written("predicate"))
            here.report(node, f'unknown predicate "{node.text}" {here.where}', hint)
        else:
            here.report(node, f'unexpected "{here.quote(node)}" {here.where}, expected an atom')


PKS = PksDialect()


def resolver_of(
    markup: Markup, vocabulary: Vocabulary, where: str, free: dict[str, Symbol] | None = None
) -> NameResolver:
    """A resolver for the names in one part of a file, with empty scope; `free` collects unbound variables."""
    return NameResolver(markup.source, markup.text, vocabulary, where, PKS, free=free)


def bind(here: NameResolver, variables: Sequence[tuple[Expression, Expression | None]]) -> dict[str, Symbol]:
    """The variables of a parameter list or quantifier, by their names in the file."""
    vocabulary, found = here.vocabulary, dict[str, Symbol]()
    for word, kind_word in variables:
        if word.text in found:
            here.report(word, f'the variable "{word.text}" stands twice in this list')
            continue
        kind = _kind_of(here, kind_word)
        taken = [symbol.name for symbol in (*here.scope.values(), *found.values())]
        name = vocabulary.names.free(word.text.lstrip("?"), taken)
        found[word.text] = Symbol("variable", name, here.place(word), kind, type=vocabulary.types.common(kind))
    return found


def _kind_of(here: NameResolver, word: Expression | None) -> Kind:
    """The type that a word names; `object` if there is none, ANY after a report."""
    types = here.vocabulary.types
    name = OBJECT if word is None else word.text
    if word is None or name in types.known:
        return (types.known[name],)
    hint = here.findings.near(name, list(types.known))
    here.report(word, f'unknown type "{name}" {here.where}', hint)
    return ANY
