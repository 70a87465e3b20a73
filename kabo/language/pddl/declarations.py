"""PDDL declarations: types, constants, predicates, functions, and the typed lists that all of them use."""

from collections.abc import Iterator
from typing import Literal

from kabo.language.pddl.forms import Form, Node, Token
from kabo.language.resolver import NameResolver
from kabo.language.types import ANY, NUMBER, NUMBERS, OBJECT, Kind, type_of, types_of
from kabo.language.vocabulary import Symbol

_MOST_ALTERNATIVES = 64


def typed_list(here: NameResolver, nodes: list[Node]) -> Iterator[tuple[Token, Node | None]]:
    """Each name of a typed list `a b - t c` with its type, or None if it has none."""
    waiting: list[Token] = []
    position = 0
    while position < len(nodes):
        node = nodes[position]
        position += 1
        if isinstance(node, Form):
            here.report(node, f'unexpected "{here.quote(node)}", expected a name')
        elif node.text != "-":
            waiting.append(node)
        elif position == len(nodes):
            here.report(node, "a type must follow this hyphen")
        else:
            kind = nodes[position]
            position += 1
            if not waiting:
                here.report(node, "no name stands before this hyphen")
            for word in waiting:
                yield word, kind
            waiting = []
    for word in waiting:
        yield word, None


def read_types(here: NameResolver, section: Form | None) -> None:
    """Declares the types of `(:types …)`; `object` always exists, and is the supertype of types declared without one."""
    types = here.vocabulary.types
    written = [] if section is None else list(typed_list(here, section.rest))
    types.declare(OBJECT, None)
    declared: dict[str, Token] = {}
    for word, _ in written:
        if word.text != OBJECT and word.text not in types.known:
            types.declare(word.text, here.place(word))
            declared[word.text] = word
    for _, kind in written:  # what stands only behind a hyphen is a type as well
        if isinstance(kind, Token) and kind.text not in types.known:
            types.declare(kind.text, here.place(kind))
            declared[kind.text] = kind
    parents: dict[str, str] = {}
    for word, kind in written:
        parent = _parent(here, kind)
        if word.text == OBJECT:
            if parent not in (None, OBJECT):
                here.report(word, '"object" is the root of all types and has no supertype')
        elif parents.setdefault(word.text, parent or OBJECT) != (parent or OBJECT):
            message = f'the type "{word.text}" has two supertypes, "{parents[word.text]}" and "{parent}"'
            here.report(word, f"{message}: not supported", "kabo's types form a tree")
    for name in declared:
        types.parents[types.known[name]] = types.known.get(parents.get(name, OBJECT), types.known[OBJECT])
    for name, word in declared.items():
        if types.known[OBJECT] not in types.ancestors(types.known[name]):
            here.report(word, f'the type "{name}" is its own supertype')
            types.parents[types.known[name]] = types.known[OBJECT]


def _parent(here: NameResolver, kind: Node | None) -> str | None:
    if isinstance(kind, Form):
        if kind.head == "either" and len(kind.items) == 2 and isinstance(kind.items[1], Token):
            return kind.items[1].text
        here.report(kind, "a type with several supertypes (either …) is not supported", "kabo's types form a tree")
        return None
    return None if kind is None else kind.text


def read_kinds(here: NameResolver, node: Node | None) -> Kind | None:
    """The types that a type specifier allows: a single type, or those of `(either a b)`; None after an error."""
    types = here.vocabulary.types
    if node is None:
        return (types.known[OBJECT],)
    words = [node]
    if isinstance(node, Form):
        if node.head != "either" or len(node.items) < 2:
            here.report(node, f'unexpected "{here.quote(node)}", expected a type or (either …)')
            return None
        words = node.rest
    kinds: list[str] = []
    for word in words:
        if not isinstance(word, Token):
            here.report(word, "expected the name of a type")
            return None
        if word.text not in types.known:
            hint = here.findings.near(word.text, list(types.known))
            here.report(word, f'unknown type "{word.text}"', hint)
            return None
        kinds.append(types.known[word.text])
    return tuple(dict.fromkeys(kinds))


# ------------------------------------------------------------------------------------------ predicates, functions
def read_predicates(here: NameResolver, section: Form | None) -> None:
    """Declares the predicates of `(:predicates …)`."""
    for node in [] if section is None else section.rest:
        _declare(here, node, "predicate")


def read_functions(here: NameResolver, section: Form | None) -> None:
    """Declares the functions of `(:functions …)`; values are numbers, or objects of the type after the hyphen."""
    waiting: list[Node] = []
    nodes = [] if section is None else section.rest
    position = 0
    while position < len(nodes):
        node = nodes[position]
        position += 1
        if isinstance(node, Form):
            waiting.append(node)
            continue
        if node.text != "-" or position == len(nodes):
            here.report(node, f'unexpected "{node.text}", expected "(name …)" or "- type" in (:functions …)')
            continue
        kind = nodes[position]
        position += 1
        number = isinstance(kind, Token) and kind.text == NUMBER
        value: Kind | None = NUMBERS if number else read_kinds(here, kind)
        _declare_functions(here, waiting, value or NUMBERS)
        waiting = []
    _declare_functions(here, waiting, NUMBERS)


def _declare_functions(here: NameResolver, nodes: list[Node], value: Kind) -> None:
    for node in nodes:
        _declare(here, node, "function", value)


def _declare(here: NameResolver, node: Node, role: Literal["predicate", "function"], value: Kind = ANY) -> None:
    vocabulary = here.vocabulary
    if not isinstance(node, Form) or not node.head:
        here.report(node, f'unexpected "{here.quote(node)}", expected "(name ?x - type …)" for a {role}')
        return
    name = node.head
    kinds = [read_kinds(here, kind) for _, kind in typed_list(here, node.rest)]
    earlier = vocabulary.symbols.get(name)
    if earlier is not None:
        message = f'"{name}" is already the name of {earlier.description}'
        here.report(node.items[0], message, vocabulary.declared_at(earlier))
        return
    arguments = tuple(ANY if each is None else each for each in kinds)
    own, place = vocabulary.names.take(name), here.place(node.items[0])
    vocabulary.symbols[name] = Symbol(role, own, place, value, arguments, original=name)


# -------------------------------------------------------------------------------------------- objects, variables
def read_objects(here: NameResolver, section: Form | None, what: str) -> None:
    """Declares the objects of `(:objects …)` or `(:constants …)`."""
    objects = here.vocabulary.objects
    for word, kind in typed_list(here, [] if section is None else section.rest):
        kinds = read_kinds(here, kind) or ANY
        if word.text.startswith("?"):
            here.report(word, f'"{word.text}" is a variable, expected the name of {what}')
        elif len(types_of(kinds)) > 1:
            here.report(word, f'"{word.text}" is of several types (either …): not supported for {what}')
        elif word.text in objects:
            if objects[word.text].kind != kinds:
                here.report(word, f'"{word.text}" is declared twice, with different types')
        else:
            name, place = here.vocabulary.names.take(word.text), here.place(word)
            objects[word.text] = Symbol("object", name, place, kinds, original=word.text, type=type_of(kinds))


def read_variables(here: NameResolver, nodes: list[Node], *, split: bool = True) -> list[dict[str, Symbol]]:
    """The variables of a parameter list or quantifier, by their names in the file.

    Args:
        here: the declared names and the variables in scope; the new variables get names in kabo that differ from
            them.
        nodes: the items of the parameter list.
        split: whether a variable of type (either a b) gives one alternative with type a and one with type b.

    Returns:
        The alternatives, each with all variables of the list; more than one only if a variable has several types.
    """
    alternatives: list[dict[str, Symbol]] = [{}]
    for word, kind in typed_list(here, nodes):
        kinds = read_kinds(here, kind)
        kinds = ANY if kinds is None else kinds
        if not word.text.startswith("?") or len(word.text) < 2:
            here.report(word, f'"{word.text}" is no variable', f'write "?{word.text}"')
            continue
        if word.text in alternatives[0]:
            here.report(word, f'the variable "{word.text}" stands twice in this list')
            continue
        taken = {symbol.name for symbol in (*here.scope.values(), *alternatives[0].values())}
        name = here.vocabulary.names.free(word.text[1:], taken)
        place = here.place(word)
        choices: list[Kind] = [(each,) for each in types_of(kinds)] if split and kinds else [kinds]
        if len(alternatives) * len(choices) > _MOST_ALTERNATIVES:
            here.report(word, "too many combinations of types (either …) in one list")
            choices = choices[:1]
        alternatives = [
            {
                **found,
                word.text: Symbol("variable", name, place, choice, type=here.vocabulary.types.common(choice)),
            }
            for found in alternatives
            for choice in choices
        ]
    return alternatives
